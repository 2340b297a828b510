-- A chain of 16 links comes to rest in a little wind.
demo{
  title = "Catenary",
  lesson = "A hanging chain takes the shape of cosh. Its horizontal pull is the same in every link; the vertical one counts the weight below.",
  seconds = 5,
  view = { x = 0, y = -0.6, height = 4 },
  friction = 0,
}
local n = param("links", 16, 6, 60)
assert(n % 2 == 0, "links must be even")
local span, l = 4, 5.2 / n
-- It starts as a zigzag of the right span: two straight halves.
local angle = math.acos(span / (n * l))
local links, hinges = {}, {}
local x, y, before = -span / 2, 0
for i = 1, n do
  local a = i <= n / 2 and -angle or angle
  local dx, dy = l * math.cos(a), l * math.sin(a)
  links[i] = capsule{ at = {x + dx / 2, y + dy / 2}, angle = a, from = {-l / 2, 0}, to = {l / 2, 0}, radius = 0.03, mass = 0.1, group = -1, color = i % 2 == 0 and "sky" or "blue" }
  drag(links[i], { linear = 0.5, angular = 0.002 })
  hinges[i] = hinge{ a = links[i], b = before, at = {x, y} }
  x, y, before = x + dx, y + dy, links[i]
end
hinges[n + 1] = hinge{ a = before, at = {span / 2, y} }

-- Rigid links: sum cos(angle_i) = span / l with tan(angle_i) = (i - (n + 1) / 2) m g / H; H by bisection.
local function width(pull)
  local sum = 0
  for i = 1, n do sum = sum + 1 / math.sqrt(1 + ((i - (n + 1) / 2) * 0.1 * 9.81 / pull) ^ 2) end
  return sum * l
end
local low, high = 1e-3, 1e4
for _ = 1, 200 do
  local mid = (low + high) / 2
  if width(mid) < span then low = mid else high = mid end
end
local sag = 0
for i = 1, n // 2 do
  local t = ((n + 1) / 2 - i) * 0.1 * 9.81 / high
  sag = sag + l * t / math.sqrt(1 + t * t)
end
expect("horizontal pull", function() return math.abs(hinges[n // 2 + 1].fx) end, { equals = high, within = 1e-2 * high, unit = "N" })
expect("sag", function() local lx, ly = links[n // 2]:point(l / 2, 0) return -ly end, { equals = sag, within = 2e-3, unit = "m" })
expect("both ends carry half of the weight", function() return math.abs(hinges[1].fy) + math.abs(hinges[n + 1].fy) end,
  { equals = n * 0.1 * 9.81, within = 0.02, unit = "N" })
expect("the links hang together", function()
  local worst = 0
  for i = 2, n do
    local ax, ay = links[i - 1]:point(l / 2, 0)
    local bx, by = links[i]:point(-l / 2, 0)
    worst = math.max(worst, math.abs(ax - bx), math.abs(ay - by))
  end
  return worst
end, { always = true, below = 1e-10, unit = "m" })
