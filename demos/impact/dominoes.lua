-- A row of dominoes; the first is nudged.
demo{
  title = "Dominoes",
  lesson = "One nudge, and the row falls: each stone gives the next one more than it got, from the potential energy of all that stood upright.",
  seconds = 3,
  dt = 1 / 120,
  view = { x = 0.15, y = 0.5, height = 1.6, width = 4.1 },
  friction = 0.4,
}
local count = param("stones", 10, 2, 30)
local w, h, pitch, g = 0.08, 0.6, 0.3, 9.81
ground{ y = 0 }
local stones = {}
for i = 1, count do
  stones[i] = box{
    at = { (i - (count + 1) / 2) * pitch, h / 2 }, size = { w, h }, mass = 1,
    color = i == 1 and "vermilion" or i == count and "blue" or i % 2 == 0 and "sky" or "yellow",
  }
end
-- Up to the edge: half the diagonal instead of half the height. A nudge of twice that tips the first stone.
local barrier = g * (math.sqrt(w ^ 2 + h ^ 2) - h) / 2
local lever = (w ^ 2 + h ^ 2) / 3 -- moment of inertia about the lower edge, for 1 kg
at(0.2, function()
  stones[1].omega = -math.sqrt(2 * 2 * barrier / lever)
  stones[1].vx, stones[1].vy = -stones[1].omega * h / 2, stones[1].omega * -w / 2
end)
show{ "velocities", "energy" }

expect("all stand before", function() return math.abs(stones[count].angle) end, { at = 0.2, below = 1e-12, unit = "rad" })
expect("the last lies flat", function() return stones[count].angle end,
  { equals = -math.pi / 2, within = 1e-6, unit = "rad" })
expect("and half its thickness high", function() return stones[count].y end, { equals = w / 2, within = 1e-6, unit = "m" })
expect("energy comes from the fall only", energy,
  { always = true, below = count * g * h / 2 + 2.01 * barrier + 1e-9, unit = "J" })
