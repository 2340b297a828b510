-- A pyramid of boxes, each on two others: far more contact forces than equations of equilibrium.
demo{
  title = "A pyramid",
  lesson = "How the weight spreads through the boxes has many answers; but the ground must carry all of it, and nothing may creep.",
  seconds = 3,
  view = { x = 0, y = 2.1, width = 9.4, height = 5.2 },
  friction = 0.6,
}
local g, mass, w, h, gap = 9.81, 10, 1, 0.5, 0.04
local rows = param("rows", 8, 2, 20)
local floor = ground{ y = 0 }
local boxes, feet = {}, {}
for row = 1, rows do
  local count = rows - row + 1
  for i = 1, count do
    local brick = box{
      at = { (i - (count + 1) / 2) * (w + gap), (row - 0.5) * h }, size = { w, h }, mass = mass,
      color = ({ "orange", "yellow", "sky" })[(row + i) % 3 + 1],
    }
    table.insert(boxes, { body = brick, x = brick.x, y = brick.y })
    if row == 1 then table.insert(feet, contact(brick, floor)) end
  end
end
show{ "contacts", "impulses", "matrix" }

expect("the ground carries all the weight", function()
  local sum = 0
  for _, foot in ipairs(feet) do sum = sum + foot.force end
  return sum
end, { equals = rows * (rows + 1) / 2 * mass * g, within = 1e-6, unit = "N" })
expect("no box creeps", function()
  local worst = 0
  for _, brick in ipairs(boxes) do
    worst = math.max(worst, math.abs(brick.body.x - brick.x), math.abs(brick.body.y - brick.y))
  end
  return worst
end, { always = true, below = 1e-9, unit = "m" })
