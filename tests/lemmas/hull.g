# SPDX-License-Identifier: MIT
# An edge function over the hull of a packet, in units of the greatest magnitude of a term of its rays. A term is c + r
# x, |x| <= 1, with the middle c and the radius r of its interval; the radius as computed exceeds r by what the middle
# is off, but for underflow: so the first two goals are factors of r and of |c|, and leave more than the 2.001 u of
# itself by which a slope may be off that is a product with a reciprocal. The sums over the middles and over the radii
# have a product, five sums and their difference or sum.

u = 1b-24;
slack = 1b-20;
of_radius = (1 + d1) * (1 + slack) * (1 + d2) * (1 + d3) - 1;
of_middle = (1 + d1) * 0.5 * slack * (1 + d2) * (1 + d3) - 1b-24;
of_slope = 1 - 1 / ((1 + e1) * (1 + e2));
lost = h1 + (h2 + h3) * (1 + d3);
sums = ((1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - 1) * (1 + 2 * slack);

# The moment: the difference of two products of middles, with three roundings of these, for which there are 2^-22 of
# them; and what radii add, a sum, a product and four sums of products, moved by 2^-20 of itself.
of_products = (1 + d1) * (1 + d2) * 0.25 * slack * (1 + d3) * (1 + d4) - ((1 + e1) * (1 + e2) - 1);
of_widths = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + slack) * (1 + d7) * (1 + d8) - 1;

# The coefficients as they are, without the sums: p g of C and g, and a slope; an intercept and the moment (moment.g).
slope_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) - (1 + e1) * (1 + e2) * (1 + e3);
moment_term = 1.001 * ((1 + d1) * (1 + d2) - (1 + e1)) + (1 + e1) * 3.001 * u * y;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24 /\
|d8| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24 /\ |h1| <= 1b-150 /\ |h2| <= 1b-150 /\ |h3| <= 1b-150 /\ |y| <= 1
  ->
  of_radius / u >= 12.9 /\ of_middle / u >= 6.9 /\ |of_slope| / u <= 2.001 /\ of_products >= 0 /\ of_widths >= 0
  /\ |lost| <= 1b-148 /\ |sums| / u <= 7.001
  /\ |slope_term| / u <= 7.001 /\ |moment_term| / u <= 6.1 }
