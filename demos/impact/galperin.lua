-- Galperin's billiard, seen from above: two blocks and a wall count the digits of pi.
demo{
  title = "Counting pi",
  lesson = "A block 100 times as heavy as the other drives it against a wall: they collide 31 times, and with 10 000 times the mass 314 times.",
  seconds = 6,
  gravity = {0, 0},
  friction = 0,
  restitution = 1,
  stepper = "event_driven",
  dt = 1 / 240,
  view = { x = 2.3, y = 0.5, height = 3.2, width = 6 },
}
local digits = param("digits", 2, 1, 3)
local ratio = 100 ^ (digits - 1)
local wall = box{ at = {-0.2, 0.5}, size = {0.4, 2.4}, type = "static", name = "wall" }
local small = box{ at = {1, 0.5}, size = {0.5, 0.5}, mass = 1, color = "sky", name = "1 kg" }
local large = box{ at = {3, 0.5}, size = {1, 1}, mass = ratio, velocity = {-1, 0}, color = "vermilion", name = string.format("%d kg", ratio) }
show{ "contacts", "impulses", "checks" }

-- With (sqrt(M) V, sqrt(m) v) as coordinates each pair of collisions, block on block and block on wall, turns the
-- velocity by 2 theta, tan theta = sqrt(m / M); after n collisions in all both move away for good.
local start = energy()
local theta = math.atan(1 / math.sqrt(ratio))
expect("energy is kept", function() return math.abs(energy() - start) end, { always = true, below = 1e-11 * start, unit = "J" })
local n = digits == 1 and 3 or digits == 2 and 31 or 314
expect("velocity of the large block after " .. n .. " collisions", function() return large.vx end,
  { equals = -math.cos(2 * math.ceil(n / 2) * theta), within = 1e-9, unit = "m/s" })
expect("velocity of the small one", function() return math.abs(small.vx) end,
  { equals = math.sqrt(ratio) * math.abs(math.sin(2 * math.ceil(n / 2) * theta)), within = 1e-8, unit = "m/s" })
