-- Two loads on one rope over two wheels.
demo{
  title = "Atwood's machine",
  lesson = "The heavier load does not fall with g: both move with a = g (m1 - m2) / (m1 + m2), and the rope pulls with 2 m1 m2 g / (m1 + m2).",
  seconds = 1.5,
  view = { x = 0, y = 2, height = 5 },
  friction = 0,
}
local m1 = param("heavy", 3, 0.1, 100, "kg")
local m2 = param("light", 2, 0.1, 100, "kg")
assert(m1 >= m2, "heavy must be at least light")
local g = 9.81

box{ at = {0, 4.25}, size = {3, 0.1}, type = "static", name = "beam" }
for _, x in ipairs{ -1, 1 } do disc{ at = {x, 4}, radius = 0.15, type = "static" } end
local heavy = box{ at = {-1, 2.4}, size = {0.6, 0.6}, mass = m1, color = "vermilion", name = "heavy" }
local light = box{ at = {1, 1.2}, size = {0.5, 0.5}, mass = m2, color = "blue", name = "light" }
local rope = pulley{
  from = { heavy, {-1, 2.7} }, to = { light, {1, 1.45} }, over = { {-1, 4}, {1, 4} },
}
show{ "velocities", "energy" }

local a = g * (m1 - m2) / (m1 + m2)
local start = energy()
expect("it falls by a t^2 / 2", function() return 2.4 - heavy.y end,
  { at = 1, equals = a / 2, within = 1e-9, unit = "m" })
expect("the rope pulls", function() return rope.force end,
  { at = 1, equals = 2 * m1 * m2 * g / (m1 + m2), within = 1e-6, unit = "N" })
expect("the light load rises as far", function() return (light.y - 1.2) - (2.4 - heavy.y) end,
  { always = true, equals = 0, within = 1e-10, unit = "m" })
expect("energy is kept", function() return math.abs(energy() - start) end, { always = true, below = 1e-9, unit = "J" })
