-- A block on a table, pulled by a spring whose other end moves steadily.
demo{
  title = "Leaping block",
  lesson = "Static friction holds until the spring pulls with mu_s m g; sliding needs less, so the block leaps and sticks again: a violin string, a creaking door.",
  seconds = 8,
  view = { x = 1.8, y = 0.8, height = 3.2 },
  stepper = "event_driven",
}
local static = param("static friction", 0.6, 0.3, 1)
local kinetic, m, k, v, g = 0.3, 2, 40, 0.4, 9.81
ground{ y = 0, friction = kinetic, static_friction = static }
local block = box{ at = {0, 0.25}, size = {0.8, 0.5}, mass = m, friction = kinetic, static_friction = static, color = "orange", name = "block" }
local hand = disc{ at = {0.9, 0.25}, radius = 0.12, type = "kinematic", group = -1, color = "blue", name = "hand" }
move(hand, function(t) return 0.9 + v * t, 0.25 end)
spring{ from = { block, {0.4, 0.25} }, to = hand, length = 0.5, stiffness = k }

local function pull() return k * (hand.x - block.x - 0.9) end
-- It moves for the first time when k v t = mu_s m g.
local first
on_step(function(t) if not first and block.vx > 1e-9 then first = t end end)
expect("first leap when the spring pulls enough", function() return first or 0 end,
  { equals = static * m * g / (k * v), within = 1.5 / 60, unit = "s" })
local stops, sticks = 0, true
on_step(function()
  local now = block.vx < 1e-9
  if now and not sticks then stops = stops + 1 end
  sticks = now
end)
expect("it leaps and sticks again", function() return stops end, { above = 1.5, unit = "times" })
-- While the block is still slower than the hand the spring stretches on: about the pull of kinetic friction it
-- swings with the amplitude sqrt(((mu_s - mu_k) m g)^2 + (v sqrt(k m))^2). A leap starts at the end of a step, up to
-- k v dt too late.
local largest = 0
on_step(function() largest = math.max(largest, pull()) end)
expect("the largest pull", function() return largest end, {
  equals = kinetic * m * g + math.sqrt(((static - kinetic) * m * g) ^ 2 + v * v * k * m), within = k * v / 60, unit = "N" })
show{ "contacts", "velocities" }
