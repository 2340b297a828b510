-- The picture everybody knows: balls on rods, an elastic blow passes through.
demo{
  title = "Newton's cradle",
  lesson = "As many balls leave as arrive: the impulse passes through the row, contact by contact, and the balls between stay at rest.",
  seconds = 6,
  dt = 1 / 240,
  view = { x = 0, y = 0.5, height = 1.35 },
  friction = 0,
  restitution = 1,
}
local count = param("balls", 5, 2, 12)
local lifted = param("lifted", 1, 1, 4)
local angle = param("angle", 40, 5, 80, "deg")
assert(lifted < count, "lifted must be less than balls")

local radius, length, mass = 0.1, 1, 1
local balls, rods = {}, {}
local beam = box{ at = {0, length + 0.03}, size = {2 * radius * count + 0.3, 0.06}, type = "static", name = "beam" }
for i = 1, count do
  local x = (2 * i - count - 1) * radius
  local a = i <= lifted and math.rad(angle) or 0
  balls[i] = disc{
    at = { x - length * math.sin(a), length - length * math.cos(a) },
    radius = radius, mass = mass, name = tostring(i),
    color = i <= lifted and "vermilion" or i > count - lifted and "blue" or "sky",
  }
  rods[i] = rod{ from = { x, length }, to = balls[i] }
end

-- Arrows of the first impact end just inside the balls.
local blow = mass * math.sqrt(2 * 9.81 * length * (1 - math.cos(math.rad(angle))))
show{ "contacts", "impulses", "matrix", "energy", impulse_scale = blow / (0.9 * radius) }

local start = energy()
expect("energy is kept", function() return math.abs(energy() - start) end,
  { always = true, below = 1e-4 * start, unit = "J" })
expect("rods keep their length", function()
  local worst = 0
  for i, ball in ipairs(balls) do
    local x = (2 * i - count - 1) * radius
    worst = math.max(worst, math.abs(math.sqrt((ball.x - x) ^ 2 + (ball.y - length) ^ 2) - length))
  end
  return worst
end, { always = true, below = 1e-9, unit = "m" })

-- When the far side swings out for the first time, all others hang still.
local highest, others = 0, 0
on_step(function(t)
  local far = balls[count]
  if t < 1.4 and far.y > highest then
    highest = far.y
    others = 0
    for i = 1, count - lifted do others = math.max(others, balls[i].speed) end
  end
end)
local drop = length * (1 - math.cos(math.rad(angle)))
expect("the last ball rises as high as the first came from", function() return highest end,
  { at = 2, equals = drop, within = 0.01 * drop, unit = "m" })
expect("the others rest meanwhile", function() return others end, { at = 2, below = 1e-6, unit = "m/s" })
