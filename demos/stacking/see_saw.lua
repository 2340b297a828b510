-- A plank lies on two supports; a weight lands on the part that sticks out.
demo{
  title = "Contacts push, they never pull",
  lesson = "The weight on the overhang turns the plank about the near support; the far contact opens, because no contact can pull.",
  seconds = 3,
  view = { x = 0.2, y = 1.2, height = 3.4, width = 5.2 },
  friction = 0.4,
}
local weight = param("weight", 12, 10, 40, "kg")
local floor = ground{ y = 0 }
local left = box{ at = {-1.5, 0.5}, size = {0.3, 1}, type = "static", name = "far support" }
local right = box{ at = {0.5, 0.5}, size = {0.3, 1}, type = "static", name = "near support" }
local plank = box{ at = {0, 1.1}, size = {4.4, 0.2}, mass = 30, color = "orange", name = "plank" }
local load = disc{ at = {1.8, 2.2}, radius = 0.25, mass = weight, color = "vermilion", name = "weight" }
local far, near = contact(plank, left), contact(plank, right)
show{ "contacts", "impulses", "matrix", "checks" }
at(0, function() note("both supports carry the plank") end)
at(0.46, function() note("the weight turns the plank: the far contact opens") end)
at(1.65, function() note("without the weight the plank falls back") end)

expect("supports carry the plank", function() return far.force + near.force end,
  { at = 0.2, equals = 30 * 9.81, within = 1e-6, unit = "N" })
expect("no contact ever pulls", function() return math.min(far.least, near.least) end,
  { always = true, above = -1e-12, unit = "N s" })
expect("the far end lifts off", function()
  return select(2, plank:point(-2.2, -0.1)) - 1
end, { at = 1, above = 0.05, unit = "m" })
expect("and comes to rest on both supports", function() return math.abs(plank.angle) end, { below = 1e-3, unit = "rad" })
expect("the far contact has opened", function() return far.impulse end, { at = 0.8, below = 1e-12, unit = "N s" })
