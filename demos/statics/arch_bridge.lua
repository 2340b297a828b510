-- Three hinges make an arch determinate; a parabola carries an even load without bending.
demo{
  title = "Arch bridge",
  lesson = "Its own weight presses along the arch; the train bends it, one half down and the other up, and pushes the banks apart by P x / 2 f.",
  seconds = 10,
  view = { x = 15, y = -3, height = 15, width = 42 },
}
local half, L, f = 6, 30, 7
local nodes, members, deck = {}, {}, {}
local count = 2 * half
for i = 0, count do
  local x = L * i / count
  nodes[#nodes + 1] = { x, -8 + 4 * f * x * (L - x) / L ^ 2 }
end
local function add(a, b, how)
  local member = { a, b }
  for key, value in pairs(how) do member[key] = value end
  members[#members + 1] = member
  return #members
end
for i = 1, count do
  local how = { beam = true, area = 0.05, second_moment = 5e-3, depth = 0.9, hinge_b = i == half }
  add(i, i + 1, how)
end
-- Columns carry a deck of simple beams; the ends of the deck rest on the banks.
for i = 0, count do nodes[#nodes + 1] = { L * i / count, 0 }; deck[#deck + 1] = #nodes end
for i = 2, count do add(i, count + 1 + i, { second_moment = 8e-5 }) end
for i = 1, count do
  add(count + 1 + i, count + 2 + i, { beam = true, hinge_a = true, hinge_b = true, second_moment = 6e-4, depth = 0.5 })
end

local P = param("axle load", 140, 10, 300, "kN") * 1e3
local bow = bridge{
  nodes = nodes, members = members, deck = deck,
  section = { area = 0.01, modulus = 2.1e11, strength = 2.35e8, density = 7850 },
  supports = { { 1, "pinned" }, { count + 1, "pinned" }, { count + 2, "pinned" }, { 2 * count + 2, "roller" } },
  train = { axles = { P, P, P, P }, gaps = { 2.6, 2.4, 2.6 }, speed = 4.2, start = -2 },
  ground = -10, thickness = 0.4,
}
show{ "stresses" }

expect("statically determinate", function() return bow.determinacy == "statically determinate" end, { at = 0.1, above = 0 })
expect("crown hinge without moment", function() return math.abs(bow:moment(half, 1)) end,
  { always = true, below = 1e-6, unit = "N m" })
-- Thrust by moments about the crown, from the weights of the left half (nodes of the arch, columns, deck).
local before = 0
at(0, function() before = bow:reaction(1) end)
expect("thrust grows by P x / 2 f for each axle", function()
  local thrust, x = bow:reaction(1), -2 + 4.2 * 3
  local sum = 0
  for _, back in ipairs{ 0, 2.6, 5, 7.6 } do
    local at = x - back
    -- A simple beam of the deck gives its load to two columns; the first column stands on the bank.
    local side = L / count
    local left = side * math.floor(at / side)
    local share = (at - left) / side
    for _, column in ipairs{ { left, 1 - share }, { left + side, share } } do
      if column[1] > 0 then sum = sum + P * column[2] * math.min(column[1], L - column[1]) / (2 * f) end
    end
  end
  return (thrust - before - sum) / sum
end, { at = 3, equals = 0, within = 1e-10 })
expect("nothing breaks", function() return bow.breaks end, { below = 1 })
