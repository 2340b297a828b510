-- Diagonals that fall towards the middle are pulled: slender ones will do.
demo{
  title = "Pratt truss",
  lesson = "Diagonals that fall towards the middle are in tension and the posts in compression: long members are pulled, short ones pushed.",
  seconds = 10,
  view = { x = 16, y = 1, height = 17, width = 40 },
}
local panels, side, high = 8, 4, 4
local form = truss{ kind = "pratt", panels = panels, side = side, height = high }

local P = param("axle load", 160, 10, 400, "kN") * 1e3
local truss = bridge{
  nodes = form.nodes, members = form.members, deck = form.deck, supports = form.supports,
  section = { area = 0.008, second_moment = 4e-5, modulus = 2.1e11, strength = 2.35e8, density = 7850 },
  train = { axles = { P, P, P, P }, gaps = { 2.8, 2.4, 2.8 }, speed = 4.5, start = -2 },
  ground = -6, thickness = 0.34, numbers = true,
}
show{ "stresses" }

-- Shear of the end panel is the reaction; its diagonal stands at 45 degrees.
expect("first lower chord by the method of sections", function()
  local _, reaction = truss:reaction(1)
  local weight_here = 7850 * 0.008 * 9.81 * (side / 2 + side * math.sqrt(2) / 2)
  return math.abs(truss:force(1) - (reaction - weight_here) * side / high) / reaction
end, { at = 5, below = 1e-12 })
expect("equilibrium of every node", function() return truss.residual end, { always = true, below = 1e-13 })
expect("full train: diagonals of the left half are pulled", function()
  return math.min(truss:force(form.diagonals[1]), truss:force(form.diagonals[2]))
end, { at = 5, above = 0, unit = "N" })
expect("influence of the end post is that of the reaction", function()
  return math.abs(truss:influence(2 * panels - 1, 20) + (1 - 20 / (panels * side)) * math.sqrt(2))
end, { at = 1, below = 1e-12 })
expect("nothing breaks", function() return truss.breaks end, { below = 1 })
