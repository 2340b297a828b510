-- Billiards: fifteen balls that touch, and one that comes.
demo{
  title = "The break",
  lesson = "One ball meets fifteen that touch: all impacts at once, energy and momentum kept, and the picture stays a mirror image of itself.",
  seconds = 1,
  dt = 1 / 120,
  gravity = {0, 0},
  friction = 0,
  restitution = 1,
  view = { x = 0.12, y = 0, height = 0.74, width = 1.3 },
}
local r, mass = 0.0286, 0.17 -- m, kg: pool balls
local speed = param("speed", 2, 0.1, 10, "m/s")
local cue = disc{ at = {-0.35, 0}, radius = r, mass = mass, velocity = { speed, 0 }, color = "grey", name = "cue" }
local colors = { "yellow", "blue", "vermilion", "pink", "orange", "green", "sky" }
local pairs_of, index = {}, 0
for row = 0, 4 do
  local balls = {}
  for i = 0, row do
    index = index + 1
    balls[i] = disc{
      at = { row * math.sqrt(3) * r, (2 * i - row) * r }, radius = r, mass = mass,
      color = colors[index % #colors + 1], name = tostring(index),
    }
  end
  for i = 0, row do table.insert(pairs_of, { balls[i], balls[row - i] }) end
end
show{ "velocities", "contacts", "impulses" }

local start = mass * speed ^ 2 / 2
expect("kinetic energy", kinetic_energy, { always = true, equals = start, within = 1e-12 * start, unit = "J" })
expect("momentum", function() return (momentum()) end,
  { always = true, equals = mass * speed, within = 1e-12 * mass * speed, unit = "kg m/s" })
expect("the two halves are mirror images", function()
  local worst = math.abs(cue.y)
  for _, two in ipairs(pairs_of) do
    worst = math.max(worst, math.abs(two[1].x - two[2].x), math.abs(two[1].y + two[2].y))
  end
  return worst
end, { always = true, below = 1e-9, unit = "m" })
