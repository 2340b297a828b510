-- Gerber's beam: two anchor spans reach over the piers and carry a short span between them.
demo{
  title = "Cantilever bridge",
  lesson = "Two hinges make the beam determinate: the middle hangs on the cantilevers, and the moment over a pier is load times overhang.",
  seconds = 10,
  view = { x = 20, y = -0.4, height = 15, width = 50 },
}
local nodes = { { 0, 0 }, { 12, 0 }, { 16, 0, name = "left hinge" }, { 24, 0, name = "right hinge" }, { 28, 0 }, { 40, 0 } }
local P = param("axle load", 150, 10, 400, "kN") * 1e3
local beam = bridge{
  nodes = nodes, deck = { 1, 2, 3, 4, 5, 6 },
  section = { beam = true, area = 0.05, second_moment = 6e-3, depth = 1, modulus = 2.1e11, strength = 2.35e8, density = 7850 },
  members = { { 1, 2 }, { 2, 3, hinge_b = true }, { 3, 4 }, { 4, 5, hinge_a = true }, { 5, 6 } },
  supports = { { 1, "pinned" }, { 2, "roller" }, { 5, "roller" }, { 6, "roller" } },
  train = { axles = { P, P }, gaps = { 3 }, speed = 4.5, start = 1 },
  ground = -6, thickness = 0.7,
}
show{ "stresses" }

local w = 7850 * 0.05 * 9.81 -- N/m
expect("beam over the first pier: own weight alone", function()
  local _, y = beam:reaction(1)
  return beam:moment(2, 0) + w * 4 * 4 / 2 + w * 4 * 4
end, { at = 0.01, equals = 0, within = 1e-6, unit = "N m" })
-- At 4 s the axles are at 19 m and 16 m: by lever 5/8 and all of a load hang on the left hinge.
expect("moment over the pier with the train on the hung span", function()
  return beam:moment(2, 0) + w * 4 * 4 / 2 + w * 4 * 4 + (P + 5 / 8 * P) * 4
end, { at = 4, equals = 0, within = 1e-6, unit = "N m" })
expect("hinges carry no moment", function()
  return math.max(math.abs(beam:moment(2, 1)), math.abs(beam:moment(4, 0)))
end, { always = true, below = 1e-6, unit = "N m" })
expect("nothing breaks", function() return beam.breaks end, { below = 1 })
