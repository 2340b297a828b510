-- Chaos does not excuse errors: the motion cannot be foretold, its energy can.
demo{
  title = "Double pendulum",
  lesson = "Three pendulums start within a tenth of a degree and part after some seconds, yet each keeps its energy to ten digits.",
  seconds = 5,
  view = { x = 0, y = -0.1, height = 4.6 },
  friction = 0,
  stepper = "event_driven",
}
local angle = param("angle", 120, 1, 180, "deg")
local apart = param("apart", 0.05, 0, 1, "deg")

local ends, colors = {}, { "sky", "orange", "vermilion" }
for i = 1, 3 do
  local a = math.rad(angle + (i - 1) * apart)
  local dir = { math.sin(a), -math.cos(a) }
  local before
  for k = 1, 2 do
    local arm = box{
      at = { (k - 0.5) * dir[1], (k - 0.5) * dir[2] }, angle = a - math.pi / 2, size = {1, 0.08}, rounding = 0.03,
      mass = 1, group = -1, color = colors[i],
    }
    hinge{ a = arm, b = before, at = { (k - 1) * dir[1], (k - 1) * dir[2] } }
    before = arm
  end
  ends[i] = before
end
show{ "traces", "energy", trace = { { ends[1], {0.5, 0} }, { ends[2], {0.5, 0} }, { ends[3], {0.5, 0} } } }

local start = energy()
expect("energy is kept", function() return math.abs(energy() - start) end, { always = true, below = 1e-8, unit = "J" })
expect("the arms hang together", function()
  local worst = 0
  for i = 1, 3 do
    local x, y = ends[i]:point(-0.5, 0)
    worst = math.max(worst, math.abs(math.sqrt(x * x + y * y) - 1))
  end
  return worst
end, { always = true, below = 1e-10, unit = "m" })
local first, last = ends[1], ends[3]
local function distance() return math.sqrt((first.x - last.x) ^ 2 + (first.y - last.y) ^ 2) end
expect("after a second they are still together", distance, { at = 1, below = 1e-2, unit = "m" })
expect("in the end they are not", distance, { above = 0.1, unit = "m" })
