-- One blow, three laws: what a solver that treats all contacts at once gets wrong.
demo{
  title = "Three discs and the impact law",
  lesson = "Reflections give (0, 0, 1) as in nature; solving both contacts at once gives (-1/3, 2/3, 2/3) with the same momentum and energy.",
  seconds = 3,
  gravity = {0, 0},
  view = { x = 0, y = 0, width = 6, height = 3 },
  friction = 0,
  restitution = 1,
  impact_law = choice("law", { "reflections", "simultaneous", "poisson" }),
}
local exact = impact_law() == "reflections" and { 0, 0, 1 } or { -1 / 3, 2 / 3, 2 / 3 }
local r = 0.4
local discs = {}
for i = 1, 3 do
  discs[i] = disc{
    at = { (2 * i - 4) * r - (i == 1 and 1 or 0), 0 }, radius = r, mass = 1,
    velocity = { i == 1 and 1 or 0, 0 }, color = i == 1 and "vermilion" or "sky",
  }
end
show{ "contacts", "impulses", "velocities", "matrix", "checks" }
at(1, function() note("impact law: " .. impact_law()) end)

for i, disc in ipairs(discs) do
  expect("disc " .. i, function() return disc.vx end, { equals = exact[i], within = 1e-12, unit = "m/s" })
end
expect("kinetic energy", function() return kinetic_energy() end,
  { always = true, equals = 0.5, within = 1e-13, unit = "J" })
