# SPDX-License-Identifier: MIT
# Rays against boxes (L12, and trace/single_ray_boxes.h). What is moved outward covers all roundings, whatever their signs.

u = 1b-24;

# Bundles: s z against c - x. The slope has two roundings, and it is moved, which takes one more; depth, product, sum,
# c. An intercept is moved likewise, and takes part in the sum.
of_slope = (1 + 1b-20) * (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - 1;
of_place = (1 + 1b-20) * (1 + d1) * (1 + d2) * (1 + d3) - 1;

# A ray alone: (c - o) times 1 / d, which is moved toward 0 or away from it; the rounding of the product is monotone.
near = 1 - (1 + d1) * (1 + d2) * (1 - 1b-21) * (1 + d3);
far = (1 + d1) * (1 + d2) * (1 + 1b-21) * (1 + d3) - 1;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  ->
  of_slope / u >= 8.9 /\ of_place / u >= 12.9 /\ near / u >= 4.9 /\ far / u >= 4.9 }
