-- Four steps a second.
demo{
  title = "Four steps a second",
  lesson = "Impacts are found inside a step and flight is solved in closed form: with steps of a quarter of a second the bounces are still exact.",
  seconds = 6,
  dt = 0.25,
  view = { x = 0, y = 2.2, width = 7, height = 5 },
  friction = 0,
  restitution = 1,
}
local g = 9.81
ground{ y = 0 }
local balls = {}
for i = 1, 5 do
  local height = 0.7 * i
  balls[i] = {
    height = height, period = 2 * math.sqrt(2 * height / g),
    body = disc{
      at = { 1.1 * (i - 3), 0.3 + height }, radius = 0.3, mass = i, restitution = 1,
      color = ({ "yellow", "orange", "vermilion", "sky", "blue" })[i], name = string.format("%.1f m", height),
    },
  }
end
show{ "velocities", "checks" }

for _, ball in ipairs(balls) do
  expect(string.format("dropped from %.1f m", ball.height), function()
    local t = (time() + ball.period / 2) % ball.period - ball.period / 2
    return ball.body.y - 0.3 - (ball.height - g * t ^ 2 / 2)
  end, { always = true, equals = 0, within = 1e-11, unit = "m" })
end
