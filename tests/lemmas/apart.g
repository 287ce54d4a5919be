# SPDX-License-Identifier: MIT
#@ -Eprecision=100
# N - t D in double, relative to s(N) + t s(D), the sums of the magnitudes of their products. d are the roundings of one
# product, of N: the difference to a, 4 of n, product, 2 sums, and the difference; of t D: 4 of n, product, 2 sums, the
# product with t, and the difference. f are those of the same in the sizes as computed, and of the product with 12 v.

v = 1b-53;
term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) * (1 + d9) - 1;
bound = 12 * v * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8) * (1 + f9) * (1 +
f10);

{ |d1| <= 1b-53 /\ |d2| <= 1b-53 /\ |d3| <= 1b-53 /\ |d4| <= 1b-53 /\ |d5| <= 1b-53 /\ |d6| <= 1b-53 /\ |d7| <= 1b-53
  /\ |d8| <= 1b-53 /\ |d9| <= 1b-53 /\ |f1| <= 1b-53 /\ |f2| <= 1b-53 /\ |f3| <= 1b-53 /\ |f4| <= 1b-53
  /\ |f5| <= 1b-53 /\ |f6| <= 1b-53 /\ |f7| <= 1b-53 /\ |f8| <= 1b-53 /\ |f9| <= 1b-53 /\ |f10| <= 1b-53
  ->
  |term| / v <= 9.001 /\ bound / v >= 11.99 }
