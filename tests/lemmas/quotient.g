# SPDX-License-Identifier: MIT
#@ -Eprecision=128
# The quotient x / d of two determinants in double (exact/quotients.c). In units of s(X) / D: X is k, |k| <= 1 + 20 u,
# and x is k + u w. D is 1, and d is 1 + y z, where z = u s(D) / |D| and y u s(D) is the error of D.

u = 1b-53;

# x / d - X / D = by_x - k z by_d: what the errors of X and of D move. The roundings of 1 / D, of the product, and of an
# end move the rest.
by_x = u * w / (1 + y * z);
by_d = y / (1 + y * z);
by_rounding = k * ((1 + d1) * (1 + d2) * (1 + d3) - 1);

# The half-width as computed: products by two factors and a quotient for each of both parts, their sum, and q's own
# error.
width_of_x = 12 * u * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4);
width_of_d = 9 * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + d1) * (1 + d2);

{ |d1| <= 1b-53 /\ |d2| <= 1b-53 /\ |d3| <= 1b-53 /\ |f1| <= 1b-53 /\ |f2| <= 1b-53 /\ |f3| <= 1b-53 /\ |f4| <= 1b-53
  /\ k in [-1.0001, 1.0001] /\ |w| <= 8.001 /\ |y| <= 8.001 /\ z in [1b-54, 1b-9]
  ->
  |by_x| / u <= 8.2 /\ |by_d| <= 8.2 /\ |by_rounding| / u <= 3.01
  /\ width_of_x / u - 8.2 - 3.01 >= 0.7 /\ width_of_d - 8.2 >= 0.7 }
