-- From dust to boulders: the case that a single grid cannot do.
demo{
  title = "Dust and boulders",
  lesson = "Radii from 2 cm to 6 m in one box: a grid with one cell size is wrong for most of them, levels of cells or a tree suit all.",
  seconds = 2,
  gravity = {0, 0},
  friction = 0,
  restitution = 1,
  view = { x = 0, y = 0, width = 17, height = 9.6 },
}
local count = param("bodies", 220, 10, 2000)
local w, h = 8, 4.5
for _, wall in ipairs{ { {0, -h - 0.1}, {2 * w + 0.4, 0.2} }, { {0, h + 0.1}, {2 * w + 0.4, 0.2} },
                       { {-w - 0.1, 0}, {0.2, 2 * h} }, { {w + 0.1, 0}, {0.2, 2 * h} } } do
  box{ at = wall[1], size = wall[2], type = "static" }
end
-- A boulder that is too large to move, then ever smaller bodies wherever there is room.
local colors = { "blue", "vermilion", "green", "orange", "sky", "pink", "yellow" }
local placed, tries = { { x = -3.2, y = -7.4, r = 6 } }, 0
disc{ at = { placed[1].x, placed[1].y }, radius = placed[1].r, type = "static", name = "boulder" }
local small, large = 0.02, 1.3
while #placed <= count and tries < 100 * count do
  tries = tries + 1
  -- The square root: few large ones, many small.
  local r = large * (small / large) ^ math.sqrt((#placed - 1) / math.max(count - 1, 1))
  local x, y = (2 * math.random() - 1) * (w - r), (2 * math.random() - 1) * (h - r)
  local free = true
  for _, other in ipairs(placed) do
    if (x - other.x) ^ 2 + (y - other.y) ^ 2 < (r + other.r + 0.01) ^ 2 then free = false end
  end
  if free then
    local direction, speed = 2 * math.pi * math.random(), 0.5 * r ^ -0.5
    table.insert(placed, { x = x, y = y, r = r })
    disc{
      at = { x, y }, radius = r, velocity = { speed * math.cos(direction), speed * math.sin(direction) },
      color = colors[#placed % #colors + 1],
    }
  end
end
show{ "impulses" }

local start = kinetic_energy()
expect("all bodies found room", function() return #placed - 1 end, { equals = count, within = 0 })
expect("no impact is missed: energy is kept", kinetic_energy,
  { always = true, equals = start, within = 1e-9 * start, unit = "J" })
expect("and nothing overlaps", penetration, { always = true, below = 1e-6, unit = "m" })
