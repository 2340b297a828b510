-- A ball of two tonnes on a chain of links of a kilogram breaks a wall of bricks.
demo{
  title = "Wrecking ball",
  lesson = "Links of one kilogram carry two tonnes, and a blow. They neither stretch nor shake, and the swing loses nothing until it hits.",
  seconds = 6,
  view = { x = 0.4, y = 5.2, height = 11.4 },
  friction = 0.6,
}
local mass = param("ball", 2000, 50, 3000, "kg")
local n = param("links", 18, 8, 30)
local l, radius = 7.2 / n, 0.8
local top = {0, 9.2}
ground{ y = 0 }

-- A straight chain, pulled back to the left.
local angle = -1.15
local dx, dy = math.sin(angle), -math.cos(angle)
local links, hinges = {}, {}
local before
for i = 1, n do
  local x, y = top[1] + (i - 1) * l * dx, top[2] + (i - 1) * l * dy
  links[i] = capsule{ at = {x + l / 2 * dx, y + l / 2 * dy}, angle = angle - math.pi / 2, from = {-l / 2 + 0.05, 0}, to = {l / 2 - 0.05, 0}, radius = 0.05,
    mass = 1, color = i % 2 == 0 and "grey" or "sky", name = "link " .. i }
  hinges[i] = hinge{ a = links[i], b = before, at = {x, y} }
  before = links[i]
end
local reach = n * l + radius
local ball = disc{ at = {top[1] + reach * dx, top[2] + reach * dy}, radius = radius, mass = mass, color = "vermilion", name = "ball" }
hinges[n + 1] = hinge{ a = ball, b = before, at = {top[1] + n * l * dx, top[2] + n * l * dy} }

-- Every second row begins and ends with half a brick.
local bricks = {}
local w, h, rows, across = 0.7, 0.4, 11, 4
for row = 1, rows do
  local x = 1.1
  for i = 1, across + (row + 1) % 2 do
    local half = row % 2 == 0 and (i == 1 or i == across + 1)
    local width = half and w / 2 or w
    bricks[#bricks + 1] = box{ at = {x + width / 2, (row - 0.5) * h}, size = {width - 0.01, h}, mass = half and 10 or 20,
      color = (row + i) % 2 == 0 and "orange" or "yellow" }
    x = x + width
  end
end
local height = {}
for i, brick in ipairs(bricks) do height[i] = brick.y end
local bodies = { ball }
for _, list in ipairs{ links, bricks } do
  for _, body in ipairs(list) do bodies[#bodies + 1] = body end
end
local function energy()
  local sum = 0
  for _, body in ipairs(bodies) do sum = sum + body.kinetic_energy + body.mass * 9.81 * body.y end
  return sum
end
local start = energy()
local function fallen()
  local count = 0
  for i, brick in ipairs(bricks) do
    if brick.y < height[i] - h / 2 then count = count + 1 end
  end
  return count
end
-- Of the links, and the ball, the largest distance between two ends that should be one point.
local function apart()
  local worst = 0
  for i = 1, n do
    local ax, ay = links[i]:point(l / 2, 0)
    local bx, by
    if i < n then bx, by = links[i + 1]:point(-l / 2, 0) else bx, by = ball:point(-radius * dx, -radius * dy) end
    worst = math.max(worst, math.sqrt((ax - bx) ^ 2 + (ay - by) ^ 2))
  end
  return worst
end
local farthest = -10
on_step(function() farthest = math.max(farthest, ball.x) end)
show{ "velocities", "checks" }
watch("energy", energy, "J")
watch("speed of the ball", function() return ball.speed end, "m/s")
watch("pull at the top", function() return hinges[1].force end, "N")
expect("no energy is lost in the air", function() return energy() / start - 1 end, { at = 1, equals = 0, within = 1e-6 })
expect("none is made anywhere", function() return energy() / start - 1 end, { always = true, below = 1e-6 })
expect("the links hang together", apart, { always = true, below = 0.03, unit = "m" })
expect("the wall is down", fallen, { above = 15, unit = "bricks" })
expect("and the ball went through", function() return farthest end, { above = 3, unit = "m" })
at(1.5, function() note("the blow") end)
