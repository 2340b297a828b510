-- Friction stops what slides, light or heavy alike.
demo{
  title = "Sliding to a stop",
  lesson = "A box at speed v slides v\u{b2}/(2 \u{b5} g), whatever its mass: half the friction means twice the way, twice the speed four times.",
  seconds = 3,
  view = { x = 3, y = 1.7, width = 8.3, height = 4.6 },
  friction = 0,
  stepper = "event_driven", -- finds the moment at which a box stops
}
local g = 9.81
local speed = param("speed", 5, 1, 7, "m/s")
local lanes = {
  { y = 3, mu = 0.5, speed = speed, mass = 1, color = "sky", text = "1 kg" },
  { y = 2, mu = 0.5, speed = speed, mass = 100, color = "blue", text = "100 kg" },
  { y = 1, mu = 0.25, speed = speed, mass = 1, color = "orange", text = "half the friction" },
  { y = 0, mu = 0.5, speed = speed / 2, mass = 1, color = "green", text = "half the speed" },
}
for _, lane in ipairs(lanes) do
  box{ at = {3, lane.y - 0.06}, size = {8, 0.12}, type = "static", friction = lane.mu }
  -- Friction of a pair is the geometric mean: the same on both sides gives itself.
  lane.box = box{
    at = {-0.4, lane.y + 0.2}, size = {0.6, 0.4}, mass = lane.mass, friction = lane.mu,
    velocity = { lane.speed, 0 }, color = lane.color, name = lane.text,
  }
end
show{ "velocities", "contacts", "checks" }

for _, lane in ipairs(lanes) do
  expect(lane.text, function() return lane.box.x + 0.4 end,
    { equals = lane.speed ^ 2 / (2 * lane.mu * g), within = 1e-9, unit = "m" })
end
expect("all stand", kinetic_energy, { below = 1e-20, unit = "J" })
