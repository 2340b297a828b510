-- Down a ramp and round a vertical loop.
local what = choice("what", { "disc", "ring", "slider" })
local height = param("height", 2.85, 2.2, 4) -- of the start, see below
demo{
  title = "Loop the loop",
  lesson = "What slides gets round from 2.5 radii above the bottom; what rolls has put a part of its energy into turning and needs more: a disc 2.75, a ring 3.",
  seconds = 3,
  view = { x = -0.5, y = 1.5, height = 3.8, width = 7.4 },
}
local g, R, r = 9.81, 1, 0.1
local k = ({ disc = 0.5, ring = 1, slider = 0 })[what] -- I / (m r^2)
-- The centre goes round in a circle of radius d, and starts `height` times d above its lowest place. At the top it needs
-- v^2 = g d, which is 2 g d (height - 2) / (1 + k) from the fall.
local d = R - r
local limit = 2 + (1 + k) / 2

-- The track: a ramp of 45 degrees, an arc to the horizontal, the loop. It would cross itself where it leaves the loop, so
-- the way in and the way out are two chains, and one of them is of the group of the ball, which it passes through.
local corners, slope = 1440, math.pi / 4
local turn = 2 * math.pi / corners
local function add_arc(points, x, from, to)
  local n = math.floor((to - from) / turn + 0.5)
  for i = 0, n do
    local t = from + (to - from) * i / n
    points[#points + 1] = { x + R * math.sin(t), R - R * math.cos(t) }
  end
end
local foot = { -0.5 - R * math.sin(slope), R - R * math.cos(slope) } -- of the ramp
local function on_ramp(y) return { foot[1] + foot[2] - y, y } end
local way_in, way_out = { on_ramp(4) }, {}
add_arc(way_in, -0.5, -slope, 0)
add_arc(way_in, 0, 0, 1.6 * math.pi)
add_arc(way_out, 0, 0.5 * math.pi, 2 * math.pi)
way_out[#way_out + 1] = { 4, 0 }
local friction = what == "slider" and 0 or 1
local function lay(points, solid)
  return chain{ points = points, friction = friction, group = solid and 0 or -1 }
end
local first, second = lay(way_in, true), lay(way_out, false)

local start = on_ramp(height * d + r - r * math.cos(slope))
local ball = disc{
  at = { start[1] + r * math.sin(slope), start[2] + r * math.cos(slope) }, radius = r, mass = 1,
  inertia = math.max(k, 0.5) * r ^ 2, friction = friction, group = -1, color = "orange", name = what,
}
local touch = contact(ball)
show{ "traces", "velocities", "energy", "checks", strobe = 0.1 }
watch("speed", function() return ball.speed end, "m/s")
watch("normal force", function() return touch.force end, "N")

-- Each corner stops the part of the velocity that points into the next piece: 1 - turn^2 / (1 + k) of v^2 is left. On the
-- ceiling gravity pulls the ball off the pieces, and it meets the next one at less.
local function square_of_speed(angle)
  local fall = 2 * g * d / (1 + k)
  local square, t = fall * (height - 1 + math.cos(slope)), -slope
  while t < angle do
    local pressed = 1 + math.min(0, math.cos(t)) * g * d / square
    square = square * (1 - (turn * pressed) ^ 2 / (1 + k)) + fall * (math.cos(t + turn) - math.cos(t))
    t = t + turn
  end
  return square
end

-- Within half a metre of the top: impulses of the track, and of m v^2 / d - m g cos t.
local given, formula, last, duration, rounds, top = 0, 0, nil, 0, 0, 0
on_step(function(t, h)
  local now = ball.speed ^ 2 / d - g * (ball.y - R) / d
  if last and ball.y > R and math.abs(ball.x) < 0.5 then
    given, formula, duration = given + touch.force * h, formula + 0.5 * (last + now) * h, duration + h
  end
  last = now
end)
on_event(function() return ball.x end, function()
  if ball.y < 2 * R - r - 0.01 then return end
  rounds = rounds + 1
  top = math.sqrt(ball.speed ^ 2 - 2 * g * (2 * R - r - ball.y) / (1 + k))
  note("at the top: " .. string.format("%.2f", top) .. " m/s, " .. string.format("%.2f", math.sqrt(g * d)) .. " would do")
  first:remove()
  second:remove()
  first, second = lay(way_in, false), lay(way_out, true)
end)
at(0, function() note(what .. ": from " .. height .. " radii; it needs " .. limit) end)

if height > limit + 0.05 or height < limit - 0.14 then -- between them it may fly past the top
  expect("it gets round", function() return rounds end, { equals = height > limit and 1 or 0, within = 0 })
end
if height > limit + 0.08 then -- below it the flights along the ceiling span several pieces
  local energy = math.sqrt(2 * g * d * (height - 2) / (1 + k))
  expect("speed at the top, by energy", function() return top end, { below = energy, above = 0.97 * energy, unit = "m/s" })
  expect("and what the corners cost", function() return top end,
    { equals = math.sqrt(square_of_speed(math.pi)), within = 5e-3, unit = "m/s" })
  expect("the track pushes with m v^2 / d - m g cos t", function() return (given - formula) / duration end,
    { equals = 0, within = 0.1, unit = "N" })
end
