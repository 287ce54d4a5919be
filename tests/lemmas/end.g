# SPDX-License-Identifier: MIT
# Where rays that go lane by lane end along an axis (trace/lanes_hull.h): E = o + P, P = t d, is computed as
# e = fl(o + q), q = fl(P), and moved outward by s = 2^-22 fl(|o| + |e|). All is relative to |o| + |e|, of which |e| is
# the share k. So |q| <= |o| + |e| / |1 + d| <= 1 + k h2. `room` is how far the moved end, as computed, is beyond E.
# h1 and h2 are 1 / (1 + d) - 1, for a rounding d of q and of e; d3, d4 are those of s, d5 that of the moved end.
#
# Below 2^-125 a product needs no room (trace/lanes_hull.h). From there on |o| + |e| >= (1 - 2 u) 2^-125, and s may
# underflow: `spare` is the room then.

u = 1b-24;

room = 4 * u * (1 + d3) * (1 + d4) * (1 + d5) - ((1 + k * h2) * h1 + k * h2 + k * d5);
spare = room * (1 - 2 * u) * 1b-125 - 1b-150;

{ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |h1| <= 0x1.001p-24 /\ |h2| <= 0x1.001p-24 /\ k in [0, 1]
  ->
  room / u >= 0.99 /\ spare / 1b-150 >= 0.9 }
