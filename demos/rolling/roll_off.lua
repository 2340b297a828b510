-- A disc rolls from the top of a fixed cylinder, slips, and leaves it.
demo{
  title = "Leaving the cylinder",
  lesson = "The disc rolls, begins to slip when friction reaches its bound, and flies off when the normal force has fallen to zero.",
  seconds = 1.6,
  stepper = "event_driven",
  view = { x = 0.6, y = 0.3, height = 3.4 },
  friction = 0.2,
}
local R, r, start = 1, 0.25, 0.1
local reach = R + r
local cylinder = disc{ at = {0, 0}, radius = R, type = "static", name = "cylinder" }
local ball = disc{ at = { reach * math.sin(start), reach * math.cos(start) }, radius = r, mass = 1, color = "vermilion", name = "disc" }
local touch = contact(ball, cylinder)
show{ "traces", "contacts", "impulses", "velocities", "checks", strobe = 0.1 }
watch("angle", function() return math.atan(ball.x, ball.y) end, "rad")
watch("normal force", function() return touch.force end, "N")

-- Where it leaves, gravity alone bends its path to the cylinder: v^2 = g (R + r) cos t. Its horizontal velocity,
-- v cos t, is kept from there on.
local function angle_of_departure()
  return math.acos((ball.vx ^ 2 / (9.81 * reach)) ^ (1 / 3))
end
at(0, function() note("rolling") end)
at(0.99, function() note("slipping: friction at its bound") end)
at(1.27, function() note("flight") end)
-- Slip from 0.4695 rad, departure at 0.9077 rad: the solution of the equation of motion with Coulomb's law.
expect("it leaves at the known angle", angle_of_departure,
  { at = 1.5, equals = 0.907687858236848, within = 1e-12, unit = "rad" })
expect("no contact pulls", function() return touch.least end, { always = true, above = -1e-12, unit = "N s" })
