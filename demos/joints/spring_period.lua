-- Three springs of one kind with loads of 1, 4 and 9 kg.
demo{
  title = "Spring and mass",
  lesson = "The period is 2 pi sqrt(m / k): four times the mass swings half as fast, whatever the amplitude.",
  seconds = 6,
  view = { x = 0, y = -1.3, height = 3.6 },
  friction = 0,
  stepper = "event_driven",
}
local k = param("stiffness", 120, 60, 1000, "N/m")
local g, amplitude = 9.81, 0.35
box{ at = {0, 0.05}, size = {4, 0.1}, type = "static" }
local loads, periods = {}, {}
for i = 1, 3 do
  local m, x = i * i, 1.3 * (i - 2)
  -- All swing about y = -1.4: the springs are as much shorter as their loads stretch them.
  local rest = 1.4 - m * g / k
  loads[i] = box{ at = {x, -1.4 + amplitude}, size = {0.2 + 0.14 * i, 0.2 + 0.14 * i}, mass = m, color = ({ "sky", "orange", "vermilion" })[i] }
  spring{ from = {x, 0}, to = loads[i], length = rest, stiffness = k }
  local last
  on_event(function() return loads[i].vy end, function(t)
    if loads[i].y > -1.4 then
      if last then periods[i] = t - last end
      last = t
    end
  end)
  expect("period of " .. m .. " kg", function() return periods[i] or 0 end,
    { equals = 2 * math.pi * math.sqrt(m / k), within = 1e-10, unit = "s" })
  expect("place of " .. m .. " kg", function() return loads[i].y + 1.4 end,
    { at = 5, equals = amplitude * math.cos(math.sqrt(k / m) * 5), within = 1e-10, unit = "m" })
end
local start = energy()
expect("energy is kept", function() return math.abs(energy() - start) end, { always = true, below = 1e-9, unit = "J" })
show{ "velocities", "energy" }
