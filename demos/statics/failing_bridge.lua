-- One diagonal is too thin. It breaks under the train; what is left is a mechanism, and falls.
demo{
  title = "One thin diagonal",
  lesson = "A determinate truss has no member to spare: when one diagonal breaks, the rest is a mechanism and moves.",
  seconds = 7,
  view = { x = 16, y = -0.4, height = 17, width = 40 },
}
local form = truss{ kind = "pratt", panels = 8, side = 4, height = 4 }
local thin = form.diagonals[2]
form.members[thin].area = param("area of the thin one", 0.0011, 0.0005, 0.01, "m^2")
form.members[thin].second_moment = 0

local P = param("axle load", 160, 10, 400, "kN") * 1e3
local truss = bridge{
  nodes = form.nodes, members = form.members, deck = form.deck, supports = form.supports,
  section = { area = 0.012, second_moment = 6e-5, modulus = 2.1e11, strength = 2.35e8, density = 7850 },
  train = { axles = { P, P, P, P }, gaps = { 2.8, 2.4, 2.8 }, speed = 5, start = -1 },
  ground = -6, thickness = 0.34,
}
show{ "stresses" }

local broken_at = 0
on_step(function(t) if broken_at == 0 and truss.breaks > 0 then broken_at = t; note("the thin diagonal breaks") end end)
expect("the thin one breaks first, in tension", function() return (truss:peak(thin)) end, { above = 1 })
expect("while the train is on the bridge", function() return broken_at end, { above = 1.5, below = 6, unit = "s" })
expect("then the rest moves", function() return truss.moving end, { above = 0 })
expect("until then every node is in balance", function() return truss.residual end, { always = true, below = 1e-13 })
