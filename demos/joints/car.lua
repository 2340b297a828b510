-- A car with sprung wheels over bumps; its rear wheel has the motor.
demo{
  title = "Car on bumps",
  lesson = "Springs and dampers let the wheels follow the road while the body goes on nearly straight.",
  seconds = 6.2,
  view = { x = 8.9, y = 1.5, height = 7.5, width = 21 },
  friction = 0.9,
}
local stiffness = param("stiffness", 6000, 500, 50000, "N/m")
local damping = param("damping", 500, 0, 5000, "N s/m")
local speed = param("wheel speed", 9, 0, 30, "rad/s")

ground{ y = 0 }
for i = 0, 6 do disc{ at = {5 + 1.9 * i, -0.45}, radius = 0.6, type = "static", friction = 0.9 } end
local body = polygon{ at = {0, 1.15}, corners = { {-1.4, -0.25}, {1.4, -0.25}, {1.4, 0.05}, {0.3, 0.5}, {-0.8, 0.5}, {-1.4, 0.1} }, mass = 200, group = -1, color = "vermilion", name = "car" }
local front = disc{ at = {0.95, 0.4}, radius = 0.4, mass = 15, group = -1, color = "grey" }
local rear = disc{ at = {-0.95, 0.4}, radius = 0.4, mass = 15, group = -1, color = "grey" }
wheel{ a = front, b = body, axis = {0, 1}, stiffness = stiffness, damping = damping, limits = {-0.3, 0.3} }
local drive = wheel{ a = rear, b = body, axis = {0, 1}, stiffness = stiffness, damping = damping, limits = {-0.3, 0.3}, speed = -speed, motor_limit = 250 }

local way = { body = 0, wheel = 0 }
on_step(function(t)
  if body.x > 5 then
    way.body = math.max(way.body, math.abs(body.angle))
    way.wheel = math.max(way.wheel, front.y - 0.4)
  end
end)
expect("the motor stays within its torque", function() return math.abs(drive.torque) end, { always = true, below = 250 + 1e-6, unit = "N m" })
expect("it comes over the bumps", function() return body.x end, { above = 17, unit = "m" })
expect("the wheels climb them", function() return way.wheel end, { above = 0.1, unit = "m" })
expect("the body leans less than 15 degrees", function() return math.deg(way.body) end, { below = 15, unit = "deg" })
show{ "contacts", "velocities" }
