-- Column of boxes: contact k carries the weight of everything above it.
demo{
  title = "A stack of boxes",
  lesson = "Each contact carries exactly the weight above it, so the forces grow evenly from top to bottom, and nothing sinks.",
  seconds = 3,
  view = { x = 0, y = 2.4, height = 5.6 },
}
local count = param("boxes", 5, 1, 20)
local g, mass = 9.81, 10
local floor = ground{ y = 0 }
local boxes, sensors = {}, {}
for i = 1, count do
  boxes[i] = box{ at = {0, i - 0.5}, size = {1.4, 1}, mass = mass, color = i % 2 == 1 and "sky" or "blue" }
  sensors[i] = contact(boxes[i], i == 1 and floor or boxes[i - 1])
end
show{ "contacts", "impulses", "matrix", "checks" }

expect("bottom contact carries all weight", function() return sensors[1].force end,
  { equals = count * mass * g, within = 1e-6 * mass * g, unit = "N" })
expect("top contact carries one box", function() return sensors[count].force end,
  { equals = mass * g, within = 1e-6 * mass * g, unit = "N" })
expect("the top box does not sink", function() return math.abs(boxes[count].y - (count - 0.5)) end,
  { always = true, below = 1e-9, unit = "m" })
expect("nothing moves sideways", function() return math.abs(boxes[count].x) end, { below = 1e-9, unit = "m" })
