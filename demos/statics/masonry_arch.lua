-- Dry stone: nothing but compression between the voussoirs. While a line of thrust fits inside, the arch stands.
demo{
  title = "Masonry arch",
  lesson = "Stones can only push: the arch stands while a line of thrust fits between its faces, here with thickness over radius above 0.1061.",
  seconds = 2,
  view = { x = 0, y = 0.55, height = 1.9 },
  friction = 0.8,
}
local n = param("voussoirs", 15, 5, 31)
local thickness = param("thickness", 0.15, 0.08, 0.4, "m")
local inner, outer = 1 - thickness / 2, 1 + thickness / 2
ground{ y = 0 }
local stones = {}
for i = 0, n - 1 do
  local a, b = math.pi * i / n, math.pi * (i + 1) / n
  local corners = {
    { inner * math.cos(a), inner * math.sin(a) }, { outer * math.cos(a), outer * math.sin(a) },
    { outer * math.cos(b), outer * math.sin(b) }, { inner * math.cos(b), inner * math.sin(b) },
  }
  stones[#stones + 1] = polygon{ corners = corners, at = {0, 0}, density = 2000, color = i % 2 == 0 and "grey" or "sky" }
end
local feet = { contact(stones[1]), contact(stones[n]) }
show{ "thrust", "checks" }

local start = {}
for i, stone in ipairs(stones) do start[i] = { stone.x, stone.y } end
expect("no stone moves", function()
  local worst = 0
  for i, stone in ipairs(stones) do
    worst = math.max(worst, math.abs(stone.x - start[i][1]), math.abs(stone.y - start[i][2]))
  end
  return worst
end, { below = 1e-6, unit = "m" })
