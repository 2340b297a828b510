-- More supports than equilibrium can tell apart.
demo{
  title = "A beam on many legs",
  lesson = "Three equations, many legs: how the weight is shared is not determined, the matrix is singular, and the sum is right all the same.",
  seconds = 2,
  view = { x = 0, y = 1.05, width = 7.4, height = 3.4 },
}
local g = 9.81
local legs = param("legs", 9, 2, 25)
local twice = param("copies", 3, 1, 5)
local beam = box{ at = {0, 1.2}, size = {6, 0.4}, mass = 100, color = "orange", name = "beam" }
local sensors = {}
ground{ y = 0 }
for i = 1, legs do
  -- Several legs at the very same place: each contact occurs more than once.
  for _ = 1, twice do
    local leg = box{ at = { -2.8 + 5.6 * (i - 1) / (legs - 1), 0.5 }, size = {0.16, 1}, type = "static" }
    table.insert(sensors, { sensor = contact(beam, leg), x = -2.8 + 5.6 * (i - 1) / (legs - 1) })
  end
end
show{ "contacts", "impulses", "matrix" }

expect("all legs together", function()
  local sum = 0
  for _, one in ipairs(sensors) do sum = sum + one.sensor.force end
  return sum
end, { equals = 100 * g, within = 1e-6, unit = "N" })
expect("left and right balance", function()
  local moment = 0
  for _, one in ipairs(sensors) do moment = moment + one.x * one.sensor.force end
  return moment
end, { equals = 0, within = 1e-6, unit = "N m" })
expect("no leg pulls", function()
  local least = 0
  for _, one in ipairs(sensors) do least = math.min(least, one.sensor.least) end
  return least
end, { always = true, above = -1e-12, unit = "N s" })
expect("the beam rests", function() return beam.speed + math.abs(beam.omega) end, { always = true, below = 1e-12, unit = "m/s" })
