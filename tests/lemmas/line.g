# SPDX-License-Identifier: MIT
#@ -Eprecision=100
# The line of two planes: C = V_1 n_2 - V_2 n_1 and g = n_2 x n_1 in double, then F, of which each kind of term has its
# error relative to its magnitude. c and f are roundings to double of what is computed and of what its error is held
# against, d roundings to float of this term, e of the slope that it is made of.

u = 1b-24;
v = 1b-53;

# A product of C: 8 roundings of V, 4 of n, product, difference; of T as computed no more. And of g: 4 and 4, and both.
ten = (1 + c1) * (1 + c2) * (1 + c3) * (1 + c4) * (1 + c5) * (1 + c6) * (1 + c7) * (1 + c8) * (1 + c9) * (1 + c10);
of_moment = ten * (1 + c11) * (1 + c12) * (1 + c13) * (1 + c14) - 1;
of_along = ten - 1;
bound_in_double = 16 * v * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8) * (1 +
f9) * (1 + f10)
                  * (1 + f11) * (1 + f12) * (1 + f13) * (1 + f14);

# C over S: S lacks two sums, 1 / S and the product with it have one each, and it becomes a float.
as_float = (1 + c1) * (1 + c2) * (1 + c3) * (1 + c4) * (1 + d1);
slope_term = as_float * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - (1 + e1);
place_of_x = as_float * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) - 1;
moment_of_x = m * (as_float * (1 + d2) * (1 + d3) - 1) + 3.001 * u * y;

# The bound: 14 u R (1 + q / 6 u) and 13 u X R (rho + q' / 6 u), with what their own roundings may take.
bound_of_r = 14 * u * (1 + d1) * (1 + d2);
bound_of_q = 14 / 6 * (1 + d1) * (1 + d2);
blur = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4);
bound_of_x = 13 * u * blur * (1 + d5);
bound_of_q_x = 13 / 6 * blur * (1 + d5);

{ |c1| <= 1b-53 /\ |c2| <= 1b-53 /\ |c3| <= 1b-53 /\ |c4| <= 1b-53 /\ |c5| <= 1b-53 /\ |c6| <= 1b-53 /\ |c7| <= 1b-53
  /\ |c8| <= 1b-53 /\ |c9| <= 1b-53 /\ |c10| <= 1b-53 /\ |c11| <= 1b-53 /\ |c12| <= 1b-53 /\ |c13| <= 1b-53
  /\ |c14| <= 1b-53 /\ |f1| <= 1b-53 /\ |f2| <= 1b-53 /\ |f3| <= 1b-53 /\ |f4| <= 1b-53 /\ |f5| <= 1b-53
  /\ |f6| <= 1b-53 /\ |f7| <= 1b-53 /\ |f8| <= 1b-53 /\ |f9| <= 1b-53 /\ |f10| <= 1b-53 /\ |f11| <= 1b-53
  /\ |f12| <= 1b-53 /\ |f13| <= 1b-53 /\ |f14| <= 1b-53
  /\ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |e1| <= 1b-24 /\ |m| <= 1.001 /\ |y| <= 1
  ->
  |of_moment| / v <= 14.001 /\ |of_along| / v <= 10.001 /\ bound_in_double / v >= 15.99
  /\ |slope_term| / u <= 8.001 /\ |place_of_x| / u <= 5.001 /\ |moment_of_x| / u <= 6.1
  /\ bound_of_r / u >= 13.99 /\ bound_of_q >= 2.3 /\ bound_of_x / u >= 12.99 /\ bound_of_q_x >= 2.1 }
