-- Each ball hits a lighter one: the velocity climbs.
demo{
  title = "A ladder of masses",
  lesson = "A ball that hits one of a third of its mass sends it off half as fast again; five steps of that make 7.6 times the speed.",
  seconds = 2.2,
  dt = 1 / 240,
  gravity = {0, 0},
  friction = 0,
  restitution = 1,
  view = { x = 0.2, y = 0, width = 5.6, height = 2.2 },
}
local ratio = param("ratio", 1 / 3, 0.05, 1) -- of each mass to the one before
local count, speed, gap = 6, 1, 0.08

local balls, x, mass, radius = {}, -2, 8, 0.5
for i = 1, count do
  balls[i] = disc{
    at = { x, 0 }, radius = radius, mass = mass, velocity = { i == 1 and speed or 0, 0 },
    color = ({ "blue", "sky", "green", "yellow", "orange", "vermilion" })[i], name = tostring(i),
  }
  -- Mass is area, as for discs of one material.
  local next_radius = radius * math.sqrt(ratio)
  x = x + radius + gap + next_radius
  mass, radius = mass * ratio, next_radius
end
show{ "velocities", "contacts", "impulses" }

-- Two bodies: the struck one leaves with 2 m1/(m1 + m2) of the speed, the other keeps (m1 - m2)/(m1 + m2).
local gain, keep = 2 / (1 + ratio), (1 - ratio) / (1 + ratio)
expect("the last ball", function() return balls[count].vx end,
  { equals = speed * gain ^ (count - 1), within = 1e-9, unit = "m/s" })
expect("the first ball", function() return balls[1].vx end, { equals = speed * keep, within = 1e-12, unit = "m/s" })
expect("the third ball", function() return balls[3].vx end,
  { equals = speed * gain ^ 2 * keep, within = 1e-12, unit = "m/s" })
expect("momentum", function() return (momentum()) end, { always = true, equals = 8 * speed, within = 1e-12, unit = "kg m/s" })
