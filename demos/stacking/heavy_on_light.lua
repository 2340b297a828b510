-- The case that iterative solvers let sink: much weight on a light body.
demo{
  title = "Heavy on light",
  lesson = "A tonne rests on a kilogram, and the light box feels exactly the weight above it: a direct solver does not care about mass ratios.",
  seconds = 2,
  view = { x = 0, y = 1.45, height = 3.6 },
}
local g = 9.81
local ratio = param("mass ratio", 1000, 1, 1e6)
local floor = ground{ y = 0 }
local light = box{ at = {0, 0.3}, size = {0.6, 0.6}, mass = 1, color = "yellow", name = "1 kg" }
local heavy = box{ at = {0, 1.4}, size = {2.4, 1.6}, mass = ratio, color = "blue", name = "heavy" }
local below, between = contact(light, floor), contact(heavy, light)
show{ "contacts", "impulses", "matrix", "checks" }

expect("on the light box rests the heavy one", function() return between.force / (ratio * g) end,
  { equals = 1, within = 1e-9 })
expect("on the ground rest both", function() return below.force / ((ratio + 1) * g) end,
  { equals = 1, within = 1e-9 })
expect("the heavy box does not sink", function() return math.abs(heavy.y - 1.4) end,
  { always = true, below = 1e-9, unit = "m" })
