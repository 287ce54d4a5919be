# SPDX-License-Identifier: MIT
# The moment of a ray, m = s_l x_j - s_j x_l, in units of R: so |s| is at most 1/2. Of one of its two products: d are
# the roundings, h is the underflow, e is the rounding of s. The intercept is at most X and off by E y, |y| <= 1; errors
# are split into what is relative to X and what is relative to E. Bound of m: R (1.001 E + 3.001 u X) + 2^-148.

u = 1b-24;
of_x = slope * ((1 + d1) * (1 + d2) - (1 + e));
of_e = slope * (1 + e) * y;
lost = (h1 + h2) * (1 + d2); # of both products

{ |slope| <= 0.5 /\ |y| <= 1 /\ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |e| <= 1b-24 /\ |h1| <= 1b-150 /\ |h2| <= 1b-150
  ->
  2 * |of_x| / u <= 3.001 /\ 2 * |of_e| <= 1.001 /\ |lost| <= 1b-148 }
