-- The classical stack over a table's edge: the k-th block from the top sticks out by L/(2k).
demo{
  title = "How far over the edge?",
  lesson = "Ten blocks, held by nothing, reach 1.46 block lengths over the edge: half of 1 + 1/2 + 1/3 + ... A little more, and they fall.",
  seconds = 3,
  view = { x = 0.3, y = 0.75, height = 3.3, width = 5.6 },
  friction = 0.6,
}
local blocks = param("blocks", 10, 1, 20)
local fraction = param("fraction", 0.99, 0.5, 1.2) -- of the largest overhang
local length, height = 2, 0.2
local table_top = box{ at = {-2, -0.6}, size = {4, 1.2}, type = "static", name = "table" }

-- From the bottom up; the right end of each block goes L/(2k) beyond the one below.
local reach, stack = 0, {}
for i = 1, blocks do
  local k = blocks - i + 1
  reach = reach + fraction * length / (2 * k)
  stack[i] = box{
    at = { reach - length / 2, (i - 0.5) * height }, size = { length, height }, mass = 1,
    color = i % 2 == 0 and "orange" or "yellow",
  }
end
local top, foot = stack[blocks], contact(stack[1], table_top)
show{ "contacts", "impulses" }

local harmonic = 0
for k = 1, blocks do harmonic = harmonic + 1 / k end
if fraction < 1 then
  expect("the top block reaches beyond the table", function() return top.x + length / 2 end,
    { equals = fraction * length / 2 * harmonic, within = 1e-9, unit = "m" })
  expect("the table carries all blocks", function() return foot.force end,
    { equals = blocks * 9.81, within = 1e-9, unit = "N" })
  expect("nothing tips", function() return math.abs(top.angle) end, { always = true, below = 1e-9, unit = "rad" })
else
  expect("the stack falls", function() return top.y end, { below = 0, unit = "m" })
end
