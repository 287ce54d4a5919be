# SPDX-License-Identifier: MIT
# A ray against the box of the scene (rays/meet_scene.h). Distances to planes, as computed, are t (1 + error) and at
# most 2^-149 off where they underflow. Where the true near is at most the true far, `room` is what the comparison has
# to spare, relative to the true far.

u = 1b-24;

# Difference, reciprocal, product.
near = (1 + d1) * (1 + d2) * (1 + d3);
far = (1 + e1) * (1 + e2) * (1 + e3);
# The product with 1 + 2 RECIPROCAL_SLACK and the sum with 2^-126, each rounded.
room = far * (1 + 16 * u) * (1 + f1) * (1 + f2) - near;
# What both underflows and that of the product can lose, of what is added.
spare = 1b-126 * (1 + f2) - 3.01 * h;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  /\ |f1| <= 1b-24 /\ |f2| <= 1b-24 /\ |h| <= 1b-149
  ->
  room / u >= 7.9 /\ spare / 1b-126 >= 0.9 }
