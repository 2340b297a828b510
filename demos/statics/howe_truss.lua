-- The same truss with its diagonals the other way round: pushed, for timber that dislikes pulling.
demo{
  title = "Howe truss",
  lesson = "Turn the diagonals of a Pratt truss round and they are in compression, the posts in tension: timber diagonals with iron rods.",
  seconds = 10,
  view = { x = 16, y = 1, height = 17, width = 40 },
}
local panels, side = 8, 4
local form = truss{ kind = "howe", panels = panels, side = side, height = 4 }

local P = param("axle load", 60, 10, 400, "kN") * 1e3
local truss = bridge{
  nodes = form.nodes, members = form.members, deck = form.deck, supports = form.supports,
  section = { area = 0.06, second_moment = 3e-4, modulus = 1.1e10, strength = 1.6e7, density = 500 },
  train = { axles = { P, P, P, P }, gaps = { 2.8, 2.4, 2.8 }, speed = 4.5, start = -2 },
  ground = -6, thickness = 0.42, numbers = true,
}
show{ "stresses" }

expect("full train: diagonals of the left half are pushed", function()
  return math.max(truss:force(form.diagonals[1]), truss:force(form.diagonals[2]))
end, { at = 5, below = 0, unit = "N" })
expect("and the posts beside them are pulled", function() return truss:force(form.posts[1]) end,
  { at = 5, above = 0, unit = "N" })
expect("influence of the end post is that of the reaction", function()
  return math.abs(truss:influence(2 * panels - 1, 20) + (1 - 20 / (panels * side)) * math.sqrt(2))
end, { at = 1, below = 1e-12 })
expect("equilibrium of every node", function() return truss.residual end, { always = true, below = 1e-13 })
expect("nothing breaks", function() return truss.breaks end, { below = 1 })
