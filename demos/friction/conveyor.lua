-- A box is put on a moving belt.
demo{
  title = "A conveyor belt",
  lesson = "Friction pulls the box along until it is as fast as the belt; until then it falls behind by v\u{b2}/(2 \u{b5} g), and half of the work becomes heat.",
  seconds = 3,
  view = { x = 0, y = 0.8, width = 7.2, height = 3.4 },
  stepper = "event_driven", -- finds the moment at which the slip ends
}
local g = 9.81
local v = param("belt", 2, 0.2, 3, "m/s")
local mu = param("friction", 0.4, 0.1, 1)
local belt = box{ at = {0, 0}, size = {6.6, 0.5}, rounding = 0.24, type = "static", friction = mu, surface_speed = -v, name = "belt" }
local parcel = box{ at = {-2.4, 0.55}, size = {0.8, 0.6}, mass = 5, friction = mu, color = "orange", name = "box" }
show{ "impulses", "velocities", "checks" }

local slip_time = v / (mu * g)
expect("accelerates with friction", function() return parcel.vx end,
  { at = 0.2, equals = math.min(v, mu * g * 0.2), within = 1e-9, unit = "m/s" })
expect("then goes with the belt", function() return parcel.vx end, { at = 1.2, equals = v, within = 1e-9, unit = "m/s" })
expect("fell behind by v^2/(2 mu g)", function() return v * time() - (parcel.x + 2.4) end,
  { at = 1.2, equals = v ^ 2 / (2 * mu * g), within = 1e-9, unit = "m" })
