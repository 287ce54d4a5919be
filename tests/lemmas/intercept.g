# SPDX-License-Identifier: MIT
# The intercept of a ray at the waist: x = o_j - s o_main, of differences o and a slope s as computed, in units of R A:
# so |o_j| and |s o_main| are at most 1/2. d are the roundings of x, h is the underflow of its product, e are the
# roundings of o_j, o_main and s. Bounds: 3.05 u R A + 2^-149 for a slope that is a quotient, as lanes have it; 3.55 u R
# A + 2^-149 for one that is a product with a reciprocal, as hulls are made of.

u = 1b-24;
computed = (offset - along * (1 + d1)) * (1 + d2);
exact = offset * (1 + e1) - along * (1 + e2) * (1 + e3);
exact_of_product = offset * (1 + e1) - along * (1 + e2) * (1 + e3) * (1 + e4);
lost = h * (1 + d2);

{ |offset| <= 0.5 /\ |along| <= 0.5 /\ |d1| <= 1b-24 /\ |d2| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24 /\ |e4| <= 1b-24 /\ |h| <= 1b-150
  ->
  |computed - exact| / u <= 3.05 /\ |computed - exact_of_product| / u <= 3.55 /\ |lost| <= 1b-149 }

computed - exact -> offset * (d2 - e1) - along * (d1 + d2 + d1 * d2 - e2 - e3 - e2 * e3);
computed - exact_of_product -> offset * (d2 - e1)
    - along * (d1 + d2 + d1 * d2 - e2 - e3 - e4 - e2 * e3 - e2 * e4 - e3 * e4 - e2 * e3 * e4);
