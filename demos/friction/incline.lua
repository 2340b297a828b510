-- One slope, six pairs of surfaces.
local degrees = param("slope", 20, 5, 35, "deg")
demo{
  title = "Who slides?",
  lesson = "A box slides when the slope is steeper than its friction: \u{b5} < tan a. Then it speeds up with g (sin a - \u{b5} cos a), whatever its mass.",
  seconds = 1.5,
  view = { x = 0.8, y = -0.15, width = 10.6, height = 5.4 },
}
local g, a = 9.81, math.rad(degrees)
local down = { math.cos(a), -math.sin(a) }
ground{ y = 0, tilt = -a, friction = 1 }
local boxes = {}
for i, mu in ipairs{ 0.05, 0.15, 0.25, 0.4, 0.55, 0.7 } do
  local s = 5.4 - 1.5 * i -- along the slope; the slippery ones go first
  boxes[i] = {
    mu = mu, s = s,
    -- Friction of a pair is the geometric mean; that of the ground is 1.
    body = box{
      at = { s * down[1] - 0.3 * down[2], s * down[2] + 0.3 * down[1] }, angle = -a, size = {0.9, 0.6}, mass = 2 ^ i,
      friction = mu ^ 2, color = ({ "vermilion", "orange", "yellow", "green", "sky", "blue" })[i],
      name = "mu " .. mu,
    },
  }
end
show{ "contacts", "impulses", "velocities", "checks" }

for _, one in ipairs(boxes) do
  local acceleration = math.max(0, g * (math.sin(a) - one.mu * math.cos(a)))
  expect("\u{b5} = " .. one.mu .. " has slid", function()
    return one.body.x * down[1] + one.body.y * down[2] - one.s
  end, { at = 1, equals = acceleration / 2, within = 1e-9, unit = "m" })
end
