-- A Warren truss of steel: triangles all alike, so diagonals take turns in tension and compression.
demo{
  title = "Warren truss",
  lesson = "Chords carry the bending and grow towards the middle; diagonals carry the shear and change sign as the train goes by.",
  seconds = 10,
  view = { x = 16, y = 1.2, height = 15, width = 40 },
}
local panels, side = 8, 4
local form = truss{ kind = "warren", panels = panels, side = side }
local nodes, members = form.nodes, form.members

local P = param("axle load", 180, 10, 400, "kN") * 1e3
local truss = bridge{
  nodes = form.nodes, members = form.members, deck = form.deck, supports = form.supports,
  section = { area = 0.008, second_moment = 4e-5, modulus = 2.1e11, strength = 2.35e8, density = 7850 },
  train = { axles = { P, P, 0.7 * P, 0.7 * P, 0.7 * P, 0.7 * P }, gaps = { 2.6, 2.4, 2.6, 2.4, 2.6 }, speed = 5, start = -1 },
  ground = -6, thickness = 0.34, influence = 12,
}
show{ "stresses", "influence", "checks" }

-- Lower chord of the middle by moments about the node above it: the simple beam's moment over the height.
local height = side * math.sqrt(3) / 2
expect("middle chord by the method of sections", function()
  local x0, span = 3.5 * side, panels * side
  local worst = 0
  for i = 0, 32 do
    local x = span * i / 32
    -- Between the nodes the load goes to the ends of its bar.
    local function moment(at) return (at <= x0 and at * (span - x0) or x0 * (span - at)) / span end
    local left = side * math.floor(math.min(x, span - 1e-9) / side)
    local share = (x - left) / side
    local exact = ((1 - share) * moment(left) + share * moment(left + side)) / height
    worst = math.max(worst, math.abs(truss:influence(4, x) - exact))
  end
  return worst
end, { at = 1, below = 1e-12 })
expect("supports carry the whole weight", function()
  local _, a = truss:reaction(1)
  local _, b = truss:reaction(panels + 1)
  local weight = 0
  for i = 1, #members do
    local p, q = nodes[members[i][1]], nodes[members[i][2]]
    weight = weight + 7850 * 0.008 * 9.81 * math.sqrt((p[1] - q[1]) ^ 2 + (p[2] - q[2]) ^ 2)
  end
  return math.abs(a + b - weight - 4.8 * P) / weight
end, { at = 4.4, below = 1e-12 })
expect("equilibrium of every node", function() return truss.residual end, { always = true, below = 1e-13 })
expect("nothing breaks", function() return truss.breaks end, { below = 1 })
