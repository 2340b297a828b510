-- Thrown at several angles with one speed.
demo{
  title = "Throwing far",
  lesson = "45\u{b0} goes farthest; two angles that add up to 90\u{b0} land at the same place, the steep one later: range = v\u{b2} sin(2a)/g.",
  seconds = 1.7,
  view = { x = 3.4, y = 1.6, width = 9, height = 5 },
  friction = 0,
}
local g = 9.81
local speed = param("speed", 8, 2, 9, "m/s")
local throws = {
  { angle = 15, color = "yellow" }, { angle = 30, color = "orange" }, { angle = 45, color = "vermilion" },
  { angle = 60, color = "sky" }, { angle = 75, color = "blue" },
}
ground{ y = -0.15 }
for _, throw in ipairs(throws) do
  local a = math.rad(throw.angle)
  -- One group: they pass through each other, all start at the same point.
  throw.ball = disc{
    at = {0, 0}, radius = 0.15, mass = 1, velocity = { speed * math.cos(a), speed * math.sin(a) },
    group = -1, color = throw.color, name = throw.angle .. " deg",
  }
  throw.range = speed ^ 2 * math.sin(2 * a) / g
  throw.time = 2 * speed * math.sin(a) / g
end
show{ "traces", "velocities", "checks", strobe = 0.1 }

for _, throw in ipairs(throws) do
  -- After touchdown without restitution or friction a ball rolls on with vx; that part is subtracted.
  expect("range at " .. throw.angle .. "\u{b0}", function()
    return throw.ball.x - throw.ball.vx * (time() - throw.time)
  end, { equals = throw.range, within = 1e-9, unit = "m" })
end
