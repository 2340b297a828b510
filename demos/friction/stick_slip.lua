-- Blocks on an incline: who slides, who stays.
demo{
  title = "Stick and slip",
  lesson = "On the incline a block stays where tan A is at most mu; beyond, it slides with g (sin A - mu cos A).",
  seconds = 2,
  stepper = "event_driven",
  view = { x = 0, y = 0, height = 5.4 },
}
local degrees = param("slope", 25, 5, 40, "deg")
local A = math.rad(degrees)
local s, c = math.sin(A), math.cos(A)
ground{ y = 0, tilt = -A, friction = 1 }
local g = 9.81
local blocks = {}
for i, mu in ipairs{ 0.8, 0.5, 0.4, 0.2 } do
  -- The fastest is the lowest, so that they do not meet. Friction of a pair is the geometric mean: mu^2 with the incline's 1.
  local along = 1.2 * (i - 3)
  local start = { along * c + 0.25 * s, -along * s + 0.25 * c }
  blocks[i] = { mu = mu, start = start, body = box{ at = start, size = {0.9, 0.5}, angle = -A, mass = 1, friction = mu * mu,
    color = ({"green", "sky", "orange", "vermilion"})[i], name = "mu = " .. mu } }
end
show{ "contacts", "impulses", "velocities", "checks" }

for _, block in ipairs(blocks) do
  local a = math.max(0, g * (s - block.mu * c))
  expect("mu = " .. block.mu .. (a > 0 and ": slides" or ": stays"), function()
    return (block.body.x - block.start[1]) * c - (block.body.y - block.start[2]) * s
  end, { at = 0.5, equals = a * 0.5 ^ 2 / 2, within = 1e-9, unit = "m" })
end
