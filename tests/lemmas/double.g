# SPDX-License-Identifier: MIT
#@ -Eprecision=128
# Determinants in double (exact/determinants.h): errors in units of the size as computed, the product of the sums of
# the magnitudes of three vectors. d are the roundings of a product, e those of the differences in it, f those of a
# size.

u = 1b-53;

# Product and difference of the cross product, product and two sums with the third vector; e of up to three differences.
five = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5);
differences = (1 + e1) * (1 + e2);

# Two sums for each of three vectors, two products.
size = 1 / ((1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8));
determinant = (five - differences) * size;
distance = (five - differences * (1 + e3)) * size;

# e_bc: two differences more, and two sums of sizes. So has t D in N - t D: a product and a difference, a product and a
# sum. N has a difference and a sum.
third_edge = (five * (1 + d6) * (1 + d7) - differences) * size / ((1 + f9) * (1 + f10));
beyond = (five * (1 + d6) - differences * (1 + e3)) * size / (1 + f9);

# N1 D2 - N2 D1: both products of all, a product and a difference.
five_2 = (1 + a1) * (1 + a2) * (1 + a3) * (1 + a4) * (1 + a5);
size_2 = 1 / ((1 + b1) * (1 + b2) * (1 + b3) * (1 + b4) * (1 + b5) * (1 + b6) * (1 + b7) * (1 + b8));
order = (five * five_2 * (1 + d6) * (1 + d7) - differences * (1 + e3) * (1 + c1) * (1 + c2)) * size * size_2
        / ((1 + f9) * (1 + f10));

# The bounds as computed, and close calls (hits/close_calls.h), less the rounding of N -+ E and D -+ W.
sign_bound = 10 * u * (1 + f1);
order_bound = 18 * u * (1 + f1);
left_of_close = 12 * u * (1 + f1) - 8.001 * u - 1.001 * u;

{ |d1| <= 1b-53 /\ |d2| <= 1b-53 /\ |d3| <= 1b-53 /\ |d4| <= 1b-53 /\ |d5| <= 1b-53 /\ |d6| <= 1b-53 /\ |d7| <= 1b-53
  /\ |e1| <= 1b-53 /\ |e2| <= 1b-53 /\ |e3| <= 1b-53
  /\ |f1| <= 1b-53 /\ |f2| <= 1b-53 /\ |f3| <= 1b-53 /\ |f4| <= 1b-53 /\ |f5| <= 1b-53 /\ |f6| <= 1b-53 /\ |f7| <= 1b-53
  /\ |f8| <= 1b-53 /\ |f9| <= 1b-53 /\ |f10| <= 1b-53
  /\ |a1| <= 1b-53 /\ |a2| <= 1b-53 /\ |a3| <= 1b-53 /\ |a4| <= 1b-53 /\ |a5| <= 1b-53
  /\ |b1| <= 1b-53 /\ |b2| <= 1b-53 /\ |b3| <= 1b-53 /\ |b4| <= 1b-53 /\ |b5| <= 1b-53 /\ |b6| <= 1b-53 /\ |b7| <= 1b-53
  /\ |b8| <= 1b-53 /\ |c1| <= 1b-53 /\ |c2| <= 1b-53
  ->
  |determinant| / u <= 7.001 /\ |distance| / u <= 8.001 /\ |third_edge| / u <= 9.001
  /\ |beyond| / u <= 9.001 /\ |order| / u <= 17.001
  /\ sign_bound / u >= 9.99 /\ order_bound / u >= 17.99 /\ left_of_close / u >= 2.9 }
