-- A railway wheel rolls on its rail. Its flange reaches below the rail; it is a point of the disc, and touches nothing.
demo{
  title = "A part of every train goes backwards",
  lesson = "A point of the rim traces a cycloid and rests where it meets the rail; one of the flange, farther out, goes backwards below it.",
  seconds = 5,
  view = { x = 2.6, y = 0.7, height = 3.4, width = 6.6 },
}
local r = 0.5
local flange = param("flange", 0.7, 0.1, 1, "m")
local speed = param("speed", 1.25, 0.2, 2, "m/s")
ground{ y = 0, name = "rail" }
local wheel = disc{ at = {0, r}, radius = r, mass = 100, velocity = { speed, 0 }, omega = -speed / r, color = "sky", name = "wheel" }
show{ "traces", "checks", trace = { { wheel, {0, -r} }, { wheel, {0, -flange} }, { wheel, {0, -0.2} }, wheel }, strobe = 0.5 }

-- The wheel has turned by a: a point that began at distance d below the axle is at r a - d sin a, r - d cos a.
local function off_the_curve(d)
  local a = speed * time() / r
  local x, y = wheel:point(0, -d)
  return math.sqrt((x - r * a + d * math.sin(a)) ^ 2 + (y - r + d * math.cos(a)) ^ 2)
end
local function velocity_at(d) -- of a point below the axle at this distance, when it is there
  return wheel.vx + wheel.omega * d
end
at(0, function() note("rim: a cycloid") end)
expect("a point of the rim is on its cycloid", function() return off_the_curve(r) end, { always = true, below = 1e-10, unit = "m" })
expect("the flange is on its curve", function() return off_the_curve(flange) end, { always = true, below = 1e-10, unit = "m" })
expect("the rim rests where it meets the rail", function() return velocity_at(r) end, { always = true, equals = 0, within = 1e-10, unit = "m/s" })
expect("the flange at its lowest", function() return velocity_at(flange) end,
  { always = true, equals = speed * (1 - flange / r), within = 1e-10, unit = "m/s" })
at(2 * math.pi * r / speed, function() note(flange > r and "a turn: the flange is on its way back" or "a turn") end)
