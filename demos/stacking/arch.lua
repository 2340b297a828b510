-- A semicircular arch of wedges without mortar.
demo{
  title = "A stone arch",
  lesson = "Stones that only push can span a gap, if the arch is thick enough: at least 0.1075 of its radius (Milankovitch), else it hinges open.",
  seconds = 3,
  view = { x = 0, y = 0.95, height = 2.9, width = 4.7 },
  friction = 0.8,
}
local ratio = param("thickness", 0.15, 0.06, 0.4, "of the mean radius")
local stones = param("stones", 15, 5, 41)
local g, radius, density = 9.81, 2, 100
local inner, outer = radius * (1 - ratio / 2), radius * (1 + ratio / 2)
local floor = ground{ y = 0 }

local arch = {}
for i = 1, stones do
  -- Corners about the middle of the stone, anticlockwise.
  local a, b = math.pi * (i - 1) / stones, math.pi * i / stones
  local cx, cy = radius * math.cos((a + b) / 2), radius * math.sin((a + b) / 2)
  local function corner(r, angle) return { r * math.cos(angle) - cx, r * math.sin(angle) - cy } end
  arch[i] = polygon{
    at = { cx, cy }, corners = { corner(inner, a), corner(outer, a), corner(outer, b), corner(inner, b) },
    density = density, color = i == (stones + 1) // 2 and "vermilion" or i % 2 == 0 and "yellow" or "orange",
  }
end
local right, left = contact(arch[1], floor), contact(arch[stones], floor)
local crown = arch[(stones + 1) // 2]
local start = crown.y
show{ "contacts", "impulses", "checks" }

local weight = 0
for _, stone in ipairs(arch) do weight = weight + stone.mass * g end
if ratio > 0.12 then
  expect("each foot carries half of the weight", function() return right.force end,
    { equals = weight / 2, within = 1e-3 * weight, unit = "N" })
  expect("both feet carry all of it", function() return right.force + left.force end,
    { equals = weight, within = 1e-6 * weight, unit = "N" })
  expect("the crown does not move", function() return math.abs(crown.y - start) end,
    { always = true, below = 1e-6, unit = "m" })
elseif ratio < 0.1 then
  expect("the arch collapses", function() return start - crown.y end, { above = 0.2 * radius, unit = "m" })
end
