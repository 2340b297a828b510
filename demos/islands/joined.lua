-- Two towers are two islands until something lies on both.
demo{
  title = "A plank joins two islands",
  lesson = "While the plank falls there are three islands; once it lies on both edges they are one, and a load shared by the law of the lever.",
  seconds = 3,
  view = { x = 0, y = 1.7, width = 6.4, height = 4.2 },
}
local g, span = 9.81, 3
local place = param("place", 0.25, 0.1, 0.9, "of the span")
ground{ y = 0 }
local edges = {}
for side = -1, 1, 2 do
  local x = side * span / 2
  for k = 1, 3 do box{ at = { x, 0.25 + 0.5 * (k - 1) }, size = {0.9, 0.5}, mass = 20, color = "sky" } end
  edges[side] = polygon{ at = { x, 1.5 }, corners = { {-0.3, 0}, {0.3, 0}, {0, 0.4} }, mass = 5, color = "green", friction = 0.7 }
end
local plank = box{ at = {0, 2.3}, size = {4.4, 0.16}, mass = 10, color = "orange", friction = 0.7, name = "plank" }
local load = box{ at = { (place - 0.5) * span, 2.68 }, size = {0.6, 0.6}, mass = 40, color = "vermilion", friction = 0.7, name = "load" }
local left, right = contact(plank, edges[-1]), contact(plank, edges[1])
show{ "islands", "contacts", "impulses", "checks" }
at(0.1, function() note("three islands: two towers, and the plank with its load") end)
local joined = false
on_step(function()
  if joined or not (left.touching and right.touching) then return end
  joined = true
  note("one island")
end)

-- Moments about the other edge.
expect("the left edge carries", function() return left.force end,
  { equals = (10 / 2 + 40 * (1 - place)) * g, within = 0.01, unit = "N" })
expect("the right edge carries", function() return right.force end,
  { equals = (10 / 2 + 40 * place) * g, within = 0.01, unit = "N" })
expect("all is still", kinetic_energy, { below = 1e-12, unit = "J" })
