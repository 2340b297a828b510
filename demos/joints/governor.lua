-- Two weights on a turning arm, seen from above.
demo{
  title = "Governor",
  lesson = "The faster it turns, the farther the weights go out: m w^2 r = k (r - r0). That is how engines knew their speed.",
  seconds = 8,
  view = { x = 0, y = 0, height = 3 },
  gravity = {0, 0},
  friction = 0,
  stepper = "event_driven",
  dt = 1 / 30,
}
local m, k, r0 = 0.5, 40, 0.4
local speed = param("speed", 5, 0, 8, "rad/s")
local hub = disc{ at = {0, 0}, radius = 0.2, mass = 5, group = -1, color = "grey", name = "hub" }
local arm = box{ at = {0, 0}, size = {2.4, 0.06}, mass = 1, group = -1, color = "grey", name = "arm" }
weld{ a = arm, b = hub, at = {0, 0} }
local drive = hinge{ a = hub, at = {0, 0}, speed = speed / 2, motor_limit = 4 }
local weights = {}
for i, side in ipairs{ -1, 1 } do
  local ball = disc{ at = {side * r0, 0}, radius = 0.13, mass = m, group = -1, color = "orange" }
  weights[i] = slider{ a = ball, b = arm, axis = {side, 0}, stiffness = k, damping = 3, limits = {-0.1, 0.75} }
end
at(4, function() drive:set_speed(speed) note("twice as fast") end)

local function radius(w) return k * r0 / (k - m * w * w) end
expect("radius at half speed", function() return r0 + weights[1].position end,
  { at = 4, equals = radius(speed / 2), within = 1e-4, unit = "m" })
expect("radius at full speed", function() return r0 + weights[1].position end,
  { equals = radius(speed), within = 1e-4, unit = "m" })
expect("both sides alike", function() return weights[1].position - weights[2].position end,
  { always = true, equals = 0, within = 1e-9, unit = "m" })
expect("the motor keeps within its torque", function() return math.abs(drive.torque) end, { always = true, below = 4 + 1e-9, unit = "N m" })
show{ "velocities" }
