-- What does not touch is solved apart.
demo{
  title = "Many islands",
  lesson = "Bodies that touch form an island with equations of its own; the ground does not connect them, so 24 stacks are 24 small problems.",
  seconds = 2,
  view = { x = 0, y = 2.3, width = 11.4, height = 5.8 },
}
local g, stacks, height = 9.81, 8, 3
local shelves, checks = { 0, 1.75, 3.5 }, {}
ground{ y = 0 }
for s, y in ipairs(shelves) do
  if s > 1 then box{ at = {0, y - 0.06}, size = {10.8, 0.12}, type = "static" } end
  for i = 1, stacks do
    local x = (i - (stacks + 1) / 2) * 1.3
    local below
    for k = 1, height do
      local size = 0.9 - 0.2 * k
      local body = box{ at = { x, y }, size = { size + 0.2, 0.4 }, mass = k * i, color = "grey" }
      body.y = y + 0.4 * (k - 0.5)
      if k == 1 then below = contact(body) end
    end
    -- The lowest box touches the ground and the one above; upwards less downwards is what both carry.
    table.insert(checks, { sensor = below, total = (1 + 2 + 3) * i * g, upper = (2 + 3) * i * g })
  end
end
show{ "islands", "contacts" }

expect("each foot carries its stack", function()
  local worst = 0
  for _, one in ipairs(checks) do
    worst = math.max(worst, math.abs(one.sensor.force - one.total - one.upper) / one.total)
  end
  return worst
end, { below = 1e-9 })
