# SPDX-License-Identifier: MIT
# An edge function, C_z + s_j C_j + s_l C_l - x_j g_l + x_l g_j + m g_z, in units of its size as computed. Of each kind
# of term the one with the most roundings, and its error relative to its magnitude; d are the roundings of this term, e
# those of the differences and of the slope that it is made of, f and h roundings and underflow elsewhere.

u = 1b-24;

# The magnitudes of the slope terms sum up to R times this: the size lacks two products, two sums and their underflow.
sum = (1 + 5 * h1 / 1b-100) / ((1 + f1) * (1 + f2) * (1 + f3) * (1 + f4));

# A product p g of C: product, difference, 1 / size, product with it, product with a slope, five sums; e of p, g, slope.
slope_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) * (1 + d9) * (1 +
d10)
             - (1 + e1) * (1 + e2) * (1 + e3);
slope_error = slope_term * sum;

# g x: 1 / size, product with it, product with the intercept, three sums; e of g. The intercept is off by E y, |y| <= 1.
place_of_x = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) - (1 + e1);
place_of_e = (1 + e1) * y;

# g m: one sum; |m| <= 1.001 R X, and m is off by R (1.001 E + 3.001 u X).
moment_of_x = m * ((1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) - (1 + e1)) + (1 + e1) * 3.001 * u * y;
moment_of_e = (1 + e1) * 1.001 * y;

# Underflow: in C over a size of at least 2^-100, in a coefficient times a term of up to 2^65, and in six products.
lost = 2 * h1 / 1b-100 * (1 + d1) + h2 + h3 * 1b65 + 6 * h4;

# The bound as computed: 14 u R + (13 u X + 4 u R A + 2^-110) R rho, where rho lacks 5 u of itself.
bound_of_r = 14 * u * (1 + f1) * (1 + f2);
blur = (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 - 5 * u);
bound_of_x = 13 * u * blur * (1 + f5);
bound_of_e = 4 * u * blur * (1 + f5) * (1 + f6);

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |d8| <= 1b-24 /\ |d9| <= 1b-24 /\ |d10| <= 1b-24 /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  /\ |f1| <= 1b-24 /\ |f2| <= 1b-24 /\ |f3| <= 1b-24 /\ |f4| <= 1b-24 /\ |f5| <= 1b-24 /\ |f6| <= 1b-24
  /\ |h1| <= 1b-150 /\ |h2| <= 1b-150 /\ |h3| <= 1b-150 /\ |h4| <= 1b-150 /\ |m| <= 1.001 /\ |y| <= 1
  ->
  |slope_error| / u <= 13.001 /\ |place_of_x| / u <= 7.001 /\ |place_of_e| <= 1.001
  /\ |moment_of_x| / u <= 8.1 /\ |moment_of_e| <= 1.01 /\ |lost| <= 1b-48
  /\ bound_of_r / u >= 13.99 /\ bound_of_x / u >= 12.99 /\ bound_of_e / u >= 3.99 }
