-- A thousand kilometres from the origin, where numbers have fewer digits left.
demo{
  title = "Far from the origin",
  lesson = "A thousand kilometres out a coordinate is known to 0.1 nm only; the bounce and the stack are as exact as that allows.",
  seconds = 3,
  view = { x = 1e6, y = 1.6, width = 6.4, height = 4 },
  friction = 0.5,
}
local g, far = 9.81, 1e6 -- m
ground{ x = far, y = 0 }
local boxes = {}
for i = 1, 4 do
  boxes[i] = box{ at = { far - 1.4, 0.4 * (i - 0.5) }, size = {0.8, 0.4}, mass = 2, color = i % 2 == 0 and "sky" or "blue" }
end
local height, r = 2.2, 0.3
local ball = disc{ at = { far + 1.2, r + height }, radius = r, mass = 1, restitution = 1, color = "vermilion", name = "ball" }
local slider = box{ at = { far - 0.6, 0.15 }, size = {0.4, 0.3}, mass = 1, velocity = {2, 0}, color = "orange", name = "slides" }
show{ "impulses", "velocities", "checks" }

-- The first bounce at sqrt(2 h/g), back at the top after twice that.
local period = 2 * math.sqrt(2 * height / g)
expect("the ball is where the formula says", function()
  local t = (time() + period / 2) % period - period / 2
  return ball.y - r - (height - g * t ^ 2 / 2)
end, { always = true, equals = 0, within = 1e-8, unit = "m" })
expect("the stack stays", function() return math.abs(boxes[4].y - 1.4) end, { always = true, below = 1e-9, unit = "m" })
-- It stops within a step, which makes an error of at most mu g h^2/8.
expect("slides v^2/(2 mu g)", function() return slider.x - (far - 0.6) end,
  { equals = 2 ^ 2 / (2 * 0.5 * g), within = 0.5 * g / 60 ^ 2 / 8 + 1e-8, unit = "m" })
