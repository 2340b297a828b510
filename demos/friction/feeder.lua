-- A table that swings to and fro along a slope carries parts along.
demo{
  title = "A vibrating conveyor",
  lesson = "The table falls away from the parts faster than g, so they fly on while it goes back. How heavy they are does not matter.",
  seconds = 3,
  view = { x = 0, y = 0.3, width = 3.4, height = 1.5 },
  stepper = "event_driven", -- finds where slipping, sticking and flight begin and end
}
local g = 9.81
local frequency = param("frequency", 5, 2, 50, "Hz")
local lift = param("upward acceleration", 1.5, 0.5, 3, "g")
local mu = param("friction", 0.4, 0.1, 1)
local angle, omega = math.pi / 6, 2 * math.pi * frequency
local amplitude = lift * g / (omega ^ 2 * math.sin(angle))
local along, up = math.cos(angle), math.sin(angle)

-- way, speed and acceleration of the table along its slope
local function swing(t)
  local phase = omega * t
  return amplitude * (1 - math.cos(phase)), amplitude * omega * math.sin(phase), amplitude * omega ^ 2 * math.cos(phase)
end

local table_ = box{ at = {0, -0.1}, size = {3, 0.2}, type = "kinematic", friction = mu, color = "blue", name = "table" }
move(table_, function(t)
  local s = swing(t)
  return s * along, -0.1 + s * up
end)
local light = box{ at = {-1.2, 0.08}, size = {0.16, 0.16}, mass = 0.1, friction = mu, color = "orange", name = "100 g" }
local heavy = box{ at = {-0.8, 0.08}, size = {0.16, 0.16}, mass = 100, friction = mu, color = "grey", name = "100 kg" }
show{ "traces", "velocities", "checks", trace = { light, heavy } }

-- How far a point goes that sticks, slips, flies and lands without a bounce, in short steps.
local function carried(time)
  local dt = 1e-5
  local x, y, vx, vy, state = 0, 0, 0, 0, "sticks"
  local function rub(most, tvx)
    local slip = vx - tvx
    if math.abs(slip) <= most then
      vx, state = tvx, "sticks"
    else
      vx, state = vx - most * slip / math.abs(slip), "slips"
    end
  end
  for k = 1, math.floor(time / dt + 0.5) do
    local s, v, a = swing(k * dt)
    local tvx, press = v * along, g + a * up
    if state == "flies" then
      y = y + (vy - g * dt / 2) * dt
      vy = vy - g * dt
      if y <= s * up then
        y = s * up
        rub(mu * (v * up - vy), tvx)
      end
    elseif press <= 0 then
      vy, y, state = v * up, s * up, "flies"
    elseif state == "slips" or math.abs(a * along) > mu * press then
      rub(mu * press * dt, tvx)
    else
      vx = tvx
    end
    x = x + vx * dt
  end
  return x
end

local way = carried(3)
expect("carried as far as a point", function() return light.x + 1.2 end,
  { at = 3, equals = way, within = 0.02, unit = "m" })
expect("light and heavy alike", function() return heavy.x - light.x - 0.4 end, { always = true, above = -1e-9, below = 1e-9, unit = "m" })
watch("light", function() return light.x end, "m")
