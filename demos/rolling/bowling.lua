-- A disc that is thrown slides first; friction spins it up until it rolls.
demo{
  title = "Bowling",
  lesson = "Friction slows the sliding disc and spins it up until it rolls: always with two thirds of its speed, whatever the friction.",
  seconds = 2,
  stepper = "event_driven",
  view = { x = 3.2, y = 0.9, height = 3.6 },
}
local v0 = param("speed", 4, 1, 6, "m/s")
local mu = param("friction", 0.2, 0.05, 1)
local r, g = 0.5, 9.81

ground{ y = 0, friction = mu }
local disc = disc{ at = {0, r}, radius = r, mass = 1, velocity = {v0, 0}, friction = mu, color = "orange", name = "disc" }
show{ "contacts", "impulses", "velocities", "checks" }
watch("speed of the centre", function() return disc.vx end, "m/s")
watch("sliding of the lowest point", function() return disc.vx + disc.omega * r end, "m/s")

-- The laws: it rolls after v0 / (3 mu g), at 5 v0^2 / (18 mu g).
local rolls = v0 / (3 * mu * g)
at(0, function() note("sliding: friction pushes back") end)
at(rolls, function() note("rolling: no friction any more") end)
local path = 5 * v0 ^ 2 / (18 * mu * g)
expect("the end speed is two thirds", function() return disc.vx end, { equals = 2 * v0 / 3, within = 1e-12, unit = "m/s" })
expect("the lowest point rests", function() return disc.vx + disc.omega * r end, { equals = 0, within = 1e-12, unit = "m/s" })
expect("it has come as far as the formula says", function() return disc.x end,
  { at = 2, equals = path + 2 * v0 / 3 * (2 - rolls), within = 1e-11, unit = "m" })
