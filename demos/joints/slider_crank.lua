-- A motor turns a crank, a rod pushes a piston: the mechanism of every engine.
demo{
  title = "Slider-crank",
  lesson = "The piston's way is r cos(a) + sqrt(l^2 - r^2 sin(a)^2): a circle becomes nearly, but not quite, a cosine.",
  seconds = 4,
  view = { x = 0.9, y = 0, height = 2.6 },
  friction = 0,
}
local r = param("crank", 0.4, 0.1, 0.6, "m")
local l = param("rod", 1.2, 0.8, 2, "m")
local speed = param("speed", 4, 0.5, 20, "rad/s")

local wheel = box{ at = {0, 0}, size = {2 * r + 0.2, 0.2}, rounding = 0.09, mass = 4, omega = speed, group = -1, color = "blue", name = "crank", gravity_scale = 0 }
local piston = box{ at = {r + l, 0}, size = {0.5, 0.36}, mass = 1, color = "orange", name = "piston" }
for _, y in ipairs{ -0.24, 0.24 } do box{ at = {l + 0.2, y}, size = {2 * r + 0.7, 0.08}, type = "static", group = -1 } end
local bar = box{ at = {r + l / 2, 0}, size = {l, 0.09}, rounding = 0.04, mass = 0.5, group = -1, color = "grey", name = "rod" }

local drive = hinge{ a = wheel, at = {0, 0}, speed = speed }
hinge{ a = bar, b = wheel, at = {r, 0} }
hinge{ a = bar, b = piston, at = {r + l, 0} }
slider{ a = piston, axis = {1, 0} }

local function formula()
  local a = wheel.angle
  return r * math.cos(a) + math.sqrt(l * l - (r * math.sin(a)) ^ 2)
end
expect("piston where the formula says", function() return math.abs(piston.x - formula()) end,
  { always = true, below = 1e-10, unit = "m" })
expect("the motor keeps its speed", function() return wheel.omega end,
  { always = true, equals = speed, within = 1e-9, unit = "rad/s" })
watch("torque", function() return drive.torque end, "N m")
watch("piston", function() return piston.x end, "m")
