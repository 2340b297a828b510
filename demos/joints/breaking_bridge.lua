-- A footbridge of planks on hinges that hold 20 kN each; a load that is too heavy rolls over it.
demo{
  title = "Breaking bridge",
  lesson = "Every hinge tells its force. It holds the light ball; under the heavy one hinges break that would have to pull more than they can.",
  seconds = 5.5,
  view = { x = 0, y = 0, height = 8 },
  friction = 0.6,
}
local strength = param("strength", 20000, 1000, 1e6, "N")
local hinges = {}
-- The planks lie on an arc: a straight chain could not carry anything.
local n, span, half = 12, 9, 0.31
local radius, y = span / 2 / math.sin(half), -0.08
local function node(i)
  local a = half * (2 * i / n - 1)
  return radius * math.sin(a), y + radius * (math.cos(half) - math.cos(a))
end
local width = 2 * radius * math.sin(half / n)
ground{ y = -3 }
local banks = {}
for i, side in ipairs{ -1, 1 } do
  banks[i] = box{ at = {side * (span / 2 + 1.5), -1.5}, size = {3, 3}, type = "static" }
end
local before = banks[1]
for i = 1, n do
  local x1, y1 = node(i - 1)
  local x2, y2 = node(i)
  local plank = box{ at = {(x1 + x2) / 2, (y1 + y2) / 2}, size = {width, 0.16}, angle = math.atan(y2 - y1, x2 - x1),
    mass = 20, color = i % 2 == 0 and "orange" or "yellow", name = "plank " .. i }
  hinges[i] = hinge{ a = plank, b = before, at = {x1, y1}, damping = 20, break_force = strength }
  before = plank
end
hinges[n + 1] = hinge{ a = before, b = banks[2], at = {span / 2, y}, damping = 20, break_force = strength }

local largest = 0
local function broken()
  local count = 0
  for _, h in ipairs(hinges) do
    if h.alive then largest = math.max(largest, h.force) else count = count + 1 end
  end
  return count
end
local ball = disc{ at = {-5, 0.4}, radius = 0.4, mass = 60, velocity = {2, 0}, omega = -5, color = "sky", name = "light" }
at(3, function()
  ball:remove()
  disc{ at = {-5.5, 0.7}, radius = 0.7, mass = 900, velocity = {3.5, 0}, omega = -5, color = "vermilion", name = "heavy" }
  note("fifteen times the load")
end)
expect("no hinge ever carries more than it can", function() broken() return largest end, { always = true, below = strength * (1 + 1e-12), unit = "N" })
expect("the bridge holds the light load", broken, { at = 2.9, equals = 0, within = 0, unit = "hinges" })
expect("but not the heavy one", broken, { above = 0.5, unit = "hinges" })
