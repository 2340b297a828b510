-- Ground that starts to move: Newmark's block (1965), West's towers (Milne 1885), and a wheel.
demo{
  title = "A train starts",
  lesson = "Ground accelerates by a. A crate slides if a > \u{b5} g; a tower tips if a > g b/h; a wheel takes a third of the speed.",
  seconds = 3,
  stepper = "event_driven",
  view = { x = 0.2, y = 2.2, width = 11.2, height = 5.4 },
  friction = 0.9,
}
local g = 9.81
local a = param("acceleration", 3.5, 1, 4.5, "m/s^2")
local mu = param("friction of the crate", 0.2, 0.15, 0.5)
local starts = 0.5 -- s
local speed = a * starts

local floor = ground{ y = 0, type = "kinematic", name = "floor" }
move(floor, function(t)
  if t < starts then return a * t ^ 2 / 2, 0 end
  return speed * (t - starts / 2), 0
end)

-- Its friction with the floor is mu: the geometric mean of both.
local crate = box{ at = {2.6, 0.3}, size = {0.8, 0.6}, friction = mu ^ 2 / 0.9, color = "orange", name = "crate" }
local wheel = disc{ at = {-4.9, 0.35}, radius = 0.35, color = "yellow", name = "wheel" }
local towers = {}
for i, slender in ipairs{ 2, 2.6, 3.3 } do -- h/b
  local width = 0.7
  local body = box{ at = {-1.0 - 1.35 * (i - 2), width * slender / 2}, size = {width, width * slender},
    color = ({"sky", "blue", "green"})[i], name = "h/b = " .. slender }
  towers[i] = { body = body, limit = g / slender }
end
show{ "contacts", "impulses", "velocities", "checks" }

-- It slides from the beginning until it is as fast as the floor, V/(mu g) later; on which V^2/(2 mu g) (1 - mu g/a)
-- it is behind for good.
local function behind(t)
  if a <= mu * g then return 0 end
  local slides = math.min(t, speed / (mu * g))
  return speed * (t - starts / 2) - mu * g * slides ^ 2 / 2 - speed * (t - slides)
end
expect("crate ends V^2/(2 mu g) (1 - mu g/a) behind", function()
  return floor.x - (crate.x - 2.6)
end, { at = 2.9, equals = behind(2.9), within = 1e-9, unit = "m" })
-- A disc has a third of what it would have without turning.
expect("wheel is a third as fast", function() return wheel.vx end,
  { at = 2.9, equals = speed / 3, within = 1e-9, unit = "m/s" })
for _, tower in ipairs(towers) do
  local tips = a > tower.limit
  expect(tower.body.name .. (tips and " tips" or " stands"), function()
    return (math.abs(tower.body.angle) > 1e-6) == tips and 0 or 1
  end, { at = 0.5, below = 1e-12 })
end
