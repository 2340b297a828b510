-- Wheels that turn each other, and a rack at the end.
demo{
  title = "Gear train",
  lesson = "Speeds go with the inverse of the radii, torques with the radii: three wheels turn a small fast push into a slow strong pull.",
  seconds = 4,
  view = { x = 1.3, y = 0.2, height = 3.2 },
  friction = 0,
}
local torque = param("torque", 6, 0, 20, "N m")
local radii, at, colors = { 0.3, 0.6, 0.4 }, {}, { "vermilion", "sky", "green" }
local x = 0
local wheels, joints = {}, {}
for i, radius in ipairs(radii) do
  x = i == 1 and 0 or x + radii[i - 1] + radius
  at[i] = x
  wheels[i] = disc{ at = {x, 0}, radius = radius, mass = 4 * radius, group = -1, color = colors[i], name = tostring(i) }
  hinge{ a = wheels[i], at = {x, 0} }
  if i > 1 then joints[i] = gear{ a = wheels[i - 1], b = wheels[i], ratio = radii[i - 1] / radius } end
end
local bar = box{ at = {at[3] + radii[3] + 0.1, -0.4}, size = {0.2, 1.6}, mass = 2, group = -1, color = "orange", name = "rack" }
slider{ a = bar, axis = {0, 1} }
rack{ a = wheels[3], b = bar, axis = {0, 1}, radius = radii[3] }
on_step(function() wheels[1]:torque(torque) end)

-- All in terms of the first wheel: v = radius * omega is the same everywhere.
local r1 = radii[1]
local inertia = 0
for i, radius in ipairs(radii) do inertia = inertia + wheels[i].inertia * (r1 / radius) ^ 2 end
inertia = inertia + bar.mass * r1 ^ 2
local load = bar.mass * 9.81 * r1
expect("speeds are in the ratio of the radii", function()
  return math.abs(wheels[3].omega - wheels[1].omega * r1 / radii[3]) + math.abs(wheels[2].omega + wheels[1].omega * r1 / radii[2])
end, { always = true, below = 1e-11, unit = "rad/s" })
expect("angles, too, without drift", function() return math.abs(wheels[3].angle - wheels[1].angle * r1 / radii[3]) end,
  { always = true, below = 1e-11, unit = "rad" })
expect("the rack rises with (M - m g r) / I", function() return bar.y + 0.4 end,
  { at = 0.5, equals = r1 * (torque - load) / inertia * 0.125, within = 1e-9, unit = "m" })
on_event(function() return bar.y - 0.35 end, function() note("the rack is up: the push ends") torque = load end)
show{ "velocities" }
