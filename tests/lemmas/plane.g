# SPDX-License-Identifier: MIT
# D = n_z + s_j n_j + s_l n_l, in units of the size of n as computed: the error of the term with the most roundings,
# relative to its magnitude, and what PLANE_BOUND leaves after the rounding of D - W and D + W. Names as in edge.g.

u = 1b-24;
sum = (1 + 5 * h1 / 1b-100) / ((1 + f1) * (1 + f2) * (1 + f3) * (1 + f4));

# Product, difference, 1 / size, product with it, product with a slope, two sums; e of two edges and the slope.
term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - (1 + e1) * (1 + e2) * (1 + e3);
error = term * sum;
lost = 2 * h1 / 1b-100 * (1 + d1) + 5 * h2;
left = 16 * u * (1 + f5) - 10.001 * u - 1b-48 - (1 + 17 * u) * u;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  /\ |f1| <= 1b-24 /\ |f2| <= 1b-24 /\ |f3| <= 1b-24 /\ |f4| <= 1b-24 /\ |f5| <= 1b-24
  /\ |h1| <= 1b-150 /\ |h2| <= 1b-150
  ->
  |error| / u <= 10.001 /\ |lost| <= 1b-48 /\ left / u >= 4.9 }
