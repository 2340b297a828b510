-- The smallest island whose matrix has everything: single contacts, a double contact, couplings.
local restitution = param("restitution", 0.5, 0, 1)
demo{
  title = "Four bodies, four contacts",
  lesson = "Each contact is a row of W; two contacts are coupled where they share a body. A-B and C-D share none: that cell is empty.",
  seconds = 3,
  gravity = {0, 0},
  view = { x = 0, y = 0, width = 6, height = 3 },
  friction = 0,
  restitution = restitution,
}
-- A hits B; B and C are boxes face to face (two contacts); C touches D.
local a = disc{ at = {-2.9, 0.3}, radius = 0.4, mass = 1, velocity = {1.5, 0}, color = "vermilion", name = "A" }
local b = box{ at = {-0.6, 0}, size = {1, 1.4}, mass = 2, color = "orange", name = "B" }
local c = box{ at = {0.4, 0}, size = {1, 1.4}, mass = 2, color = "sky", name = "C" }
local d = disc{ at = {1.3, -0.2}, radius = 0.4, mass = 1, color = "blue", name = "D" }
show{ "contacts", "impulses", "matrix" }

expect("momentum stays", function() return (momentum()) end,
  { always = true, equals = 1.5, within = 1e-13, unit = "kg m/s" })
-- Impacts keep it to rounding; bodies that stay together (e = 0) and glide on each other to the accuracy of the steps.
local turning = a.mass * 1.5 * -0.3
expect("angular momentum stays", angular_momentum, { always = true, equals = turning, within = restitution > 0 and 1e-12 or 1e-6, unit = "kg m^2/s" })
expect("energy never grows", kinetic_energy, { always = true, below = 0.5 * 1.5 ^ 2 + 1e-12, unit = "J" })
expect("D leaves to the right", function() return d.vx end, { above = 0.1, unit = "m/s" })
