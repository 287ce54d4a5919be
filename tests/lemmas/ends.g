# SPDX-License-Identifier: MIT
#@ -Eprecision=100
# The side of a plane on which all points e of a slab and a box lie, in double, relative to Z. d are the roundings of what is
# computed, f those of Z. Each line is one kind of term with its error relative to its magnitude, which is at most Z.

v = 1b-53;

# n, as exact and as computed: two differences, product, difference. And p, of N at a point: the difference to a, n, product,
# 2 sums.
of_n = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) - 1;
of_p = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) - 1;

# r = n - k m: product, difference. p - k q - r . c: the sum of two ends, product, 3 differences; k q has the product and 4
# differences. |r| . h, with Z at its end: the difference of two ends, product, 2 sums, and the last sum.
of_r = (1 + d1) * (1 + d2) - 1;
of_middle = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - 1;
of_room = of_middle;

# q - m . e: product, 3 differences. k times that: product, sum.
of_height = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) - 1;
of_end = (1 + d1) * (1 + d2) - 1;

# A height as a float: it is rounded, and the product and difference that move it outward by 2^-20.
moved = 1b-20 * (1 - 1b-24) * (1 - 1b-24) - 1b-24 - 1b-24;

# Z: sizes of n (4), the difference to a, product, 2 sums; or the product k m, a sum, the product with e; and 4 sums.
bound = 128 * v * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8) * (1 + f9)
        * (1 + f10) * (1 + f11) * (1 + f12);

{ |d1| <= 1b-53 /\ |d2| <= 1b-53 /\ |d3| <= 1b-53 /\ |d4| <= 1b-53 /\ |d5| <= 1b-53 /\ |d6| <= 1b-53 /\ |d7| <= 1b-53
  /\ |d8| <= 1b-53 /\ |f1| <= 1b-53 /\ |f2| <= 1b-53 /\ |f3| <= 1b-53 /\ |f4| <= 1b-53 /\ |f5| <= 1b-53
  /\ |f6| <= 1b-53 /\ |f7| <= 1b-53 /\ |f8| <= 1b-53 /\ |f9| <= 1b-53 /\ |f10| <= 1b-53 /\ |f11| <= 1b-53
  /\ |f12| <= 1b-53
  ->
  |of_n| / v <= 4.001 /\ |of_p| / v <= 8.001 /\ |of_r| / v <= 2.001 /\ |of_middle| / v <= 7.001
  /\ |of_room| / v <= 7.001 /\ |of_height| / v <= 4.001 /\ |of_end| / v <= 2.001 /\ moved >= 1b-21
  /\ bound / v >= 127.99 }
