-- Kepler's laws: two planets around one sun; they do not attract each other.
demo{
  title = "Orbits",
  lesson = "A planet is fast where it is near: its line to the sun sweeps equal areas in equal times. An orbit 2.52 times as large takes 4 times as long: T\u{b2} ~ a\u{b3}.",
  seconds = 8,
  dt = 1 / 240,
  gravity = {0, 0},
  view = { x = 0.5, y = 0, width = 4.6, height = 4.2 },
}
local period, mu = 2, 4 * math.pi ^ 2 * 0.8 ^ 3 / 2 ^ 2      -- of the inner one: an axis of 0.8 m, 2 s
local e = param("eccentricity", 0.5, 0, 0.7)
local sun = disc{ at = {0, 0}, radius = 0.12, type = "static", color = "yellow", name = "sun" }

--- Begins where it is farthest from the sun.
local function planet(name, times, eccentricity, color)
  local a = 0.8 * times ^ (2 / 3)
  local far = a * (1 + eccentricity)
  local speed = math.sqrt(mu / a * (1 - eccentricity) / (1 + eccentricity))
  local body = disc{ at = {far, 0}, radius = 0.06, mass = 1, velocity = {0, speed}, color = color, name = name }
  local pull = attract{ strength = mu, bodies = {sun, body}, weights = {1, 1} }
  expect(name .. ": back after " .. times * period .. " s", function()
    return math.sqrt((body.x - far) ^ 2 + body.y ^ 2)
  end, { at = times * period, below = 0.02, unit = "m" })
  expect(name .. ": area per second", function() return (body.x * body.vy - body.y * body.vx) / 2 end,
    { always = true, equals = far * speed / 2, within = 1e-9, unit = "m\u{b2}/s" })
  return body, function() return body.kinetic_energy + pull.energy end, -mu / (2 * a)
end
local inner, energy_of_inner, energy = planet("inner", 1, e, "sky")
local outer = planet("outer", 4, 0.25, "vermilion")
expect("inner: energy", energy_of_inner, { always = true, equals = energy, within = 0.02, unit = "J" })
show{ "traces", "velocities", "checks", trace = { inner, outer }, strobe = 0.1 }
