-- Each box ten times as heavy as the one below it.
demo{
  title = "Ten times heavier, five times over",
  lesson = "From 1 kg at the bottom to 100 t at the top: every contact still carries exactly the weight above it, to nine digits.",
  seconds = 2,
  view = { x = 0, y = 2.55, width = 7, height = 6.2 },
}
local g, count = 9.81, 6
local factor = param("factor", 10, 1, 20)
local floor = ground{ y = 0 }
local y, bodies, sensors = 0, {}, {}
for i = 1, count do
  local size = 0.45 + 0.13 * i
  bodies[i] = box{
    at = { 0, y + size / 2 }, size = { 1.3 * size, size }, mass = factor ^ (i - 1),
    color = ({ "yellow", "orange", "vermilion", "green", "sky", "blue" })[i], name = string.format("%g kg", factor ^ (i - 1)),
  }
  sensors[i] = contact(bodies[i], i == 1 and floor or bodies[i - 1])
  y = y + size
end
local top = bodies[count].y
show{ "contacts", "matrix" }

for i = 1, count do
  local above = 0
  for k = i, count do above = above + factor ^ (k - 1) * g end
  expect(i == 1 and "on the ground" or "on box " .. i - 1, function() return sensors[i].force end,
    { equals = above, within = 1e-9 * above, unit = "N" })
end
expect("the top does not sink", function() return math.abs(bodies[count].y - top) end, { always = true, below = 1e-9, unit = "m" })
