# SPDX-License-Identifier: MIT
# N = n . (a - w) + n . (w - o), in units of the size of n as computed: errors of terms relative to their magnitudes,
# whose sums are F and A, and what DISTANCE_ERROR leaves after the rounding of N - E and N + E. Names as in edge.g.

u = 1b-24;
sum = (1 + 5 * h1 / 1b-100) / ((1 + f1) * (1 + f2) * (1 + f3) * (1 + f4));

# n: product, difference, 1 / size, product with it; product with an intercept; five sums or three. e of two edges, the
# intercept.
corner_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) * (1 + d9) * (1 +
d10)
              - (1 + e1) * (1 + e2) * (1 + e3);
origin_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8)
              - (1 + e1) * (1 + e2) * (1 + e3);
corner_error = corner_term * sum;
origin_error = origin_term * sum;

# Underflow: of n, and so relative to F + A; of products with intercepts and of 16 u (F + A), where DISTANCE_FLOOR is
# more.
lost_of_n = 2 * h1 / 1b-100 * (1 + d1) + h2;
lost = 7 * h3 * (1 + d1);
left = 16 * u * (1 + f5) * (1 + f6) * (1 + f7) - 13.001 * u - 1b-46 - (1 + 17 * u) * u;
left_of_floor = 1b-82 * (1 + f7) - 1b-147;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |d8| <= 1b-24 /\ |d9| <= 1b-24 /\ |d10| <= 1b-24 /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  /\ |f1| <= 1b-24 /\ |f2| <= 1b-24 /\ |f3| <= 1b-24 /\ |f4| <= 1b-24 /\ |f5| <= 1b-24 /\ |f6| <= 1b-24 /\ |f7| <= 1b-24
  /\ |h1| <= 1b-150 /\ |h2| <= 1b-150 /\ |h3| <= 1b-150
  ->
  |corner_error| / u <= 13.001 /\ |origin_error| / u <= 11.001 /\ |lost_of_n| <= 1b-48 /\ |lost| <= 1b-147
  /\ left / u >= 1.9 /\ left_of_floor >= 1b-83 }
