-- Infinitely many bounces in a finite time.
demo{
  title = "Bounce to rest",
  lesson = "Each bounce takes the share e of the last one's time, so infinitely many of them fit into three seconds - and then the ball rests.",
  seconds = 3.5,
  stepper = "event_driven",
  view = { x = 0, y = 1.1, height = 3 },
  friction = 0,
}
local g, drop, r = 9.81, 1.5, 0.25
local balls = {}
for i, e in ipairs{ 0.5, 0.6, 0.7 } do
  local x = 1.2 * (i - 2)
  local floor = box{ at = { x, -0.1 }, size = {1, 0.2}, type = "static", restitution = e, name = "e = " .. e }
  balls[i] = { body = disc{ at = { x, drop + r }, radius = r, mass = 1, restitution = 0, color = ({"sky", "orange", "green"})[i] }, e = e }
end
show{ "contacts", "impulses", "energy", "checks" }

for _, ball in ipairs(balls) do
  local rests = math.sqrt(2 * drop / g) * (1 + ball.e) / (1 - ball.e)
  local path = 0
  expect("e = " .. ball.e .. ": it moved until just before", function() return ball.highest or 0 end,
    { above = 0, unit = "m" })
  expect("e = " .. ball.e .. ": at rest from " .. string.format("%.3f", rests) .. " s on", function() return ball.late or 0 end,
    { below = 1e-9, unit = "m/s" })
  on_step(function(t)
    if t > 0.9 * rests and t < rests then ball.highest = math.max(ball.highest or 0, ball.body.y - r) end
    if t > rests then ball.late = math.max(ball.late or 0, ball.body.speed) end
  end)
end
expect("energy of the first bounce", function() return balls[3].body.y - r end,
  { at = math.floor(60 * (math.sqrt(2 * drop / g) * (1 + 0.7))) / 60, above = 0.48 * drop, unit = "m" })
