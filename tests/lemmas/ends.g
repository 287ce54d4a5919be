# SPDX-License-Identifier: MIT
#@ -Eprecision=100
# The side of a plane on which all points e of a box lie, in double, relative to Z. d are the roundings of what is
# computed, f those of Z. Each line is one kind of term with its error relative to its magnitude, which is at most Z.

v = 1b-53;

# p, of N at a point: the difference to a, n (two differences, product, difference), product, 2 sums; and 3 differences
# more.
of_p = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) * (1 + d9) * (1 + d10) * (1
+ d11) - 1;

# n_k e_k: n, product, 3 differences.
of_e = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) - 1;

# Z: sizes of n (4), the difference to a, product, 2 sums; or the product with e; and 3 sums.
bound = 16 * v * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8) * (1 + f9)
        * (1 + f10) * (1 + f11) * (1 + f12);

{ |d1| <= 1b-53 /\ |d2| <= 1b-53 /\ |d3| <= 1b-53 /\ |d4| <= 1b-53 /\ |d5| <= 1b-53 /\ |d6| <= 1b-53 /\ |d7| <= 1b-53
  /\ |d8| <= 1b-53 /\ |d9| <= 1b-53 /\ |d10| <= 1b-53 /\ |d11| <= 1b-53 /\ |f1| <= 1b-53 /\ |f2| <= 1b-53
  /\ |f3| <= 1b-53 /\ |f4| <= 1b-53 /\ |f5| <= 1b-53 /\ |f6| <= 1b-53 /\ |f7| <= 1b-53 /\ |f8| <= 1b-53
  /\ |f9| <= 1b-53 /\ |f10| <= 1b-53 /\ |f11| <= 1b-53 /\ |f12| <= 1b-53
  ->
  |of_p| / v <= 11.001 /\ |of_e| / v <= 8.001 /\ bound / v >= 15.99 }
