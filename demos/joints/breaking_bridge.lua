-- A footbridge of planks on hinges that hold 12 kN each; a load that is too heavy rolls over it.
demo{
  title = "Breaking bridge",
  lesson = "Every hinge tells its force. The light ball passes; under the heavy one the hinge with the largest pull breaks first.",
  seconds = 6,
  dt = 1 / 120,
  view = { x = 0, y = 0, height = 8 },
  friction = 0.6,
}
local strength = param("strength", 12000, 1000, 1e6, "N")
local planks, hinges = {}, {}
local n, w = 12, 0.75
for _, side in ipairs{ -1, 1 } do box{ at = {side * (n * w / 2 + 1), -1.5}, size = {2, 3}, type = "static" } end
local before
for i = 1, n do
  local x = (i - 0.5 - n / 2) * w
  planks[i] = box{ at = {x, -0.1}, size = {w, 0.16}, mass = 20, color = "orange", name = "plank " .. i }
  hinges[i] = hinge{ a = planks[i], b = before, at = {x - w / 2, -0.1}, break_force = strength }
  before = planks[i]
end
hinges[n + 1] = hinge{ a = before, at = {n * w / 2, -0.1}, break_force = strength }

local largest = 0
local function broken()
  local count = 0
  for _, h in ipairs(hinges) do
    if h.alive then largest = math.max(largest, h.force) else count = count + 1 end
  end
  return count
end
local ball = disc{ at = {-5, 0.4}, radius = 0.4, mass = 60, velocity = {3, 0}, omega = -7.5, color = "sky", name = "light" }
at(3, function()
  ball:remove()
  disc{ at = {-5.2, 0.7}, radius = 0.7, mass = 900, velocity = {3, 0}, omega = -4.3, color = "vermilion", name = "heavy" }
  note("fifteen times the load")
end)
expect("no hinge ever carries more than it can", function() broken() return largest end, { always = true, below = strength * (1 + 1e-12), unit = "N" })
expect("the light load passes", broken, { at = 2.9, equals = 0, within = 0, unit = "hinges" })
expect("the heavy one does not", broken, { above = 0.5, unit = "hinges" })
