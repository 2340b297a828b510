-- Flight is solved in closed form: no step size shows in the numbers.
demo{
  title = "Free fall",
  lesson = "Light or heavy, everything falls alike: y = h - g t\u{b2}/2, and an elastic ball climbs back to where it came from.",
  seconds = 4,
  view = { x = 0, y = 2.6, height = 6 },
  friction = 0,
}
local g = 9.81
local height = param("height", 4.5, 1, 5, "m")
local bounce = param("restitution", 0.8, 0, 1)

ground{ y = 0 }
local heavy = disc{ at = {-2.4, height}, radius = 0.5, mass = 1000, restitution = 1, color = "blue", name = "1000 kg" }
local light = disc{ at = {0, height}, radius = 0.25, mass = 0.001, restitution = 1, color = "orange", name = "1 g" }
local soft = disc{ at = {2.4, height}, radius = 0.4, mass = 1, restitution = bounce, color = "green", name = "soft" }

show{ "contacts", "velocities", "energy", "checks" }

expect("heavy ball follows h - g t^2/2", function()
  return math.abs(heavy.y - (height - g * time() ^ 2 / 2))
end, { at = 0.5, below = 1e-12, unit = "m" })
expect("light ball does the same", function()
  return math.abs(light.y - heavy.y)
end, { at = 0.5, below = 1e-12, unit = "m" })

-- Elastic: the height over the floor is periodic, so energy is the exact check of all bounces.
local start = heavy.mass * g * height
expect("elastic ball keeps its energy", function()
  return math.abs(heavy.kinetic_energy + heavy.mass * g * heavy.y - start) / start
end, { always = true, below = 1e-12 })

-- Each bounce leaves e^2 of the height over the floor.
local first_peak = 0
local down = math.sqrt(2 * (height - 0.4) / g)
on_step(function(t)
  if t > down and t < down * (1 + 2 * bounce) then first_peak = math.max(first_peak, soft.y - 0.4) end
end)
expect("first rebound reaches e^2 of the height", function()
  return first_peak / (height - 0.4)
end, { at = 3, equals = bounce ^ 2, within = 2e-3 })
