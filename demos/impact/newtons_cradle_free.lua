-- The cradle without rods or gravity: the exact answer is known.
demo{
  title = "Newton's cradle, free discs",
  lesson = "k discs arrive, k discs leave with the same speed, exactly; momentum and energy allow other outcomes, nature does not take them.",
  seconds = 3,
  gravity = {0, 0},
  view = { x = 0, y = 0, width = 7, height = 2.4 },
  friction = 0,
  restitution = 1,
}
local count = param("discs", 5, 2, 50)
local moving = param("moving", 2, 1, 4)
assert(moving < count, "moving must be less than discs")
local speed = 1 -- m/s
local r = math.min(0.3, 3 / count)

local discs = {}
for i = 1, count do
  local x = (2 * i - count - 1) * r
  discs[i] = disc{
    at = { i <= moving and x - 1 or x, 0 }, radius = r, mass = 1,
    velocity = { i <= moving and speed or 0, 0 },
    color = i <= moving and "vermilion" or i > count - moving and "blue" or "sky",
  }
end
show{ "contacts", "impulses", "velocities", "matrix", impulse_scale = math.min(moving, count - moving) * speed / (0.9 * r) }

expect("worst velocity error", function()
  local worst = 0
  for i, d in ipairs(discs) do
    local exact = i > count - moving and speed or 0
    worst = math.max(worst, math.abs(d.vx - exact), math.abs(d.vy), math.abs(d.omega) * r)
  end
  return worst
end, { below = 1e-12, unit = "m/s" })
expect("momentum", function() return (momentum()) end,
  { always = true, equals = moving * speed, within = 1e-13 * moving, unit = "kg m/s" })
expect("kinetic energy", function() return kinetic_energy() end,
  { always = true, equals = 0.5 * moving * speed ^ 2, within = 1e-13 * moving, unit = "J" })
