-- Much faster than a frame: the path between two frames counts, not the places.
demo{
  title = "A bullet",
  lesson = "At 300 m/s the bullet moves 5 m a frame; it still hits the plate of 2 cm, and sticks: v = m u/(m + M).",
  seconds = 1.5,
  gravity = {0, 0},
  friction = 0,
  view = { x = 0.6, y = 0, width = 5, height = 2.6 },
}
local speed = param("speed", 300, 1, 3000, "m/s")
local m, mass = 0.01, 2
local bullet = disc{ at = {-1.6, 0}, radius = 0.03, mass = m, color = "vermilion", name = "bullet" }
local plate = box{ at = {0, 0}, size = {0.02, 1.4}, mass = mass, color = "blue", name = "plate" }
-- Sleepers beside the path: they must not notice.
local sleepers = {}
for i = 1, 4 do
  for side = -1, 1, 2 do
    table.insert(sleepers, box{ at = { -1.9 + 0.42 * i, side * 0.24 }, size = {0.34, 0.34}, mass = 1, color = "sky" })
  end
end
at(0.5, function() bullet.vx = speed end)
show{ "contacts", "impulses", "velocities", "checks" }

local after = m * speed / (m + mass)
expect("plate and bullet go on together", function() return plate.vx end, { equals = after, within = 1e-9, unit = "m/s" })
expect("the bullet sticks to it", function() return bullet.vx - plate.vx end, { equals = 0, within = 1e-9, unit = "m/s" })
expect("it is on the near side", function() return plate.x - bullet.x end, { always = true, above = 0, unit = "m" })
expect("the boxes beside the path stay", function()
  local worst = 0
  for _, sleeper in ipairs(sleepers) do worst = math.max(worst, sleeper.speed) end
  return worst
end, { always = true, below = 1e-15, unit = "m/s" })
