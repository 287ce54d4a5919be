# SPDX-License-Identifier: MIT
# The filter of the kd-tree (hits/triangle_filter.h, mlrta): edge functions and D in units of the size of their cross
# product as computed, N in units of A. Names as in single.g.

u = 1b-24;

# The size lacks, of itself: the vectors' sums and edges, products, sums and the larger of sum and edge.
size = 1 / ((1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8));

# e_ij: product, difference, 1 / size, product with it, product with d, two sums; e of a sum of two differences and an
# edge: the sum is rounded once more than its terms.
edge_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - (1 + e1) * (1 + e2) * (1 + e3);
edge = edge_term * size;

# D: two edges. N has the roundings of e_ij.
plane_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - (1 + e1) * (1 + e2);
plane = plane_term * size;

# What is left of the bounds for comparisons: less the rounding of N -+ E and D -+ W.
left_of_d = 16 * u * (1 + f9) - 9.001 * u - 1.001 * u;
left_of_n = 12 * u * (1 + f9) - 10.001 * u - 1.001 * u;

# The ends of t: t D / N is between 1 - s and 1 + 2 s, where s = W / D < 1/2 and the error of D is at most 10 / 16 of W.
upper = (1 + 2 * s) - 1 / (1 - 10 / 16 * s);
lower = 1 / (1 + 10 / 16 * s) - (1 - s);

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  /\ |f1| <= 1b-24 /\ |f2| <= 1b-24 /\ |f3| <= 1b-24 /\ |f4| <= 1b-24 /\ |f5| <= 1b-24 /\ |f6| <= 1b-24 /\ |f7| <= 1b-24
  /\ |f8| <= 1b-24 /\ |f9| <= 1b-24 /\ s in [1b-24, 0.5]
  ->
  |edge| / u <= 10.001 /\ |plane| / u <= 9.001
  /\ left_of_d / u >= 5.9 /\ left_of_n / u >= 0.9 /\ upper >= 0 /\ lower >= 0 }
