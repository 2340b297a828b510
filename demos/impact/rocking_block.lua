-- Housner's rocking block: what a block loses when it goes over to its other corner.
demo{
  title = "Rocking block",
  lesson = "A block that rocks from corner to corner keeps 1 - (3/2) sin^2 A of its spin in each impact: slender ones rock for long.",
  seconds = 6,
  stepper = "event_driven",
  view = { x = 0, y = 1.6, height = 5 },
  friction = 2,
}
ground{ y = 0 }
local blocks = {}
for i, slender in ipairs{ 1, 2, 4 } do
  local b = 0.35
  local h = b * slender
  local tilt = 0.3 * math.atan(1 / slender)
  local s, c = math.sin(tilt), math.cos(tilt)
  local foot = 2.4 * (i - 2) + b
  -- On its right corner, leaning to the right.
  local body = box{ at = { foot - b * c + h * s, h * c + b * s }, size = {2 * b, 2 * h}, angle = -tilt, mass = 1,
    color = ({"sky", "orange", "green"})[i], name = "h/b = " .. slender }
  local sine = 1 / math.sqrt(1 + slender * slender)
  blocks[i] = { body = body, share = 1 - 1.5 * sine * sine, h = h, b = b, last = 0 }
end
show{ "contacts", "impulses", "energy", "checks" }

-- A block about a corner has the energy m g R cos(A - |t|) + 2/3 m R^2 w^2; the largest spin between two
-- impacts is that at the second, so the ratio of the spins of two upright passages follows from the energy.
local function height_of_swing(k)
  local block = blocks[k]
  local R, A = math.sqrt(block.h ^ 2 + block.b ^ 2), math.atan(block.b / block.h)
  local body = block.body
  return 2 / 3 * R * R * body.omega ^ 2 + 9.81 * (body.y - block.h)
end
for k, block in ipairs(blocks) do
  block.energies = { height_of_swing(k) }
  on_step(function()
    local now = height_of_swing(k)
    local before = block.energies[#block.energies]
    if math.abs(now - before) > 1e-7 and #block.energies < 2 then table.insert(block.energies, now) end
  end)
  expect("h/b = " .. math.floor(block.h / block.b + 0.5) .. ": share of the spin kept", function()
    return math.sqrt(block.energies[2] / block.energies[1])
  end, { at = 5, equals = block.share, within = 1e-9 })
end
