-- Cables, hangers and a stiffening girder: indeterminate, so the stiffness of the members decides.
demo{
  title = "Suspension bridge",
  lesson = "The cable hangs in tension everywhere; the girder only spreads a load over many hangers, and bends most under the train.",
  seconds = 12,
  view = { x = 30, y = 1.5, height = 26, width = 128 },
}
local L, sag, tower, panels, back = 60, 8, 10, 12, 20
local nodes, members, deck = {}, {}, {}
local function node(x, y) nodes[#nodes + 1] = { x, y }; return #nodes end
local function add(a, b, how)
  local member = { a, b }
  for key, value in pairs(how) do member[key] = value end
  members[#members + 1] = member
  return #members
end
local girder = { beam = true, area = 0.05, second_moment = 0.007, depth = 1.2 }
local main = { cable = true, area = 0.005 }
local hanger = { cable = true, area = 0.0008 }

local first = node(-back, 0)
deck[1] = first
for i = 0, panels do deck[#deck + 1] = node(L * i / panels, 0) end
local last = node(L + back, 0)
deck[#deck + 1] = last
for i = 1, #deck - 1 do add(deck[i], deck[i + 1], girder) end

local cable = {}
for i = 0, panels do
  local x = L * i / panels
  cable[i] = node(x, tower - 4 * sag * x * (L - x) / L ^ 2)
end
local left_anchor, right_anchor = node(-back - 8, 0), node(L + back + 8, 0)
local backstay = add(left_anchor, cable[0], main)
for i = 1, panels do add(cable[i - 1], cable[i], main) end
add(cable[panels], right_anchor, main)
for i = 1, panels - 1 do add(deck[i + 2], cable[i], hanger) end
local mast = { area = 0.015, second_moment = 1e-3, strength = 2.35e8 }
add(deck[2], cable[0], mast)
add(deck[panels + 2], cable[panels], mast)

local P = param("axle load", 150, 10, 400, "kN") * 1e3
local span = bridge{
  nodes = nodes, members = members, deck = deck,
  section = { modulus = 2.1e11, strength = 4.5e8, density = 7850 },
  supports = {
    { first, "pinned" }, { deck[2], "roller" }, { deck[panels + 2], "roller" }, { last, "roller" },
    { left_anchor, "pinned" }, { right_anchor, "pinned" },
  },
  train = { axles = { P, P, P, P, P, P }, gaps = { 3, 4, 3, 4, 3 }, speed = 10, start = -10 },
  ground = -10, thickness = 0.9,
}
show{ "stresses" }

expect("every cable is in tension", function()
  local least = math.huge
  for i = backstay, backstay + 2 * panels do least = math.min(least, span:force(i)) end
  return least
end, { always = true, above = 0, unit = "N" })
-- The horizontal pull is the same in the whole cable: hangers pull straight down.
expect("one horizontal pull in the cable", function()
  local function pull(i)
    local a, b = nodes[members[i][1]], nodes[members[i][2]]
    return span:force(i) * (b[1] - a[1]) / math.sqrt((b[1] - a[1]) ^ 2 + (b[2] - a[2]) ^ 2)
  end
  local worst = 0
  for i = backstay + 2, backstay + panels do worst = math.max(worst, math.abs(pull(i) / pull(backstay + 1) - 1)) end
  return worst
end, { at = 5, below = 1e-12 })
expect("equilibrium of every node", function() return span.residual end, { always = true, below = 1e-11 })
expect("nothing breaks", function() return span.breaks end, { below = 1 })
