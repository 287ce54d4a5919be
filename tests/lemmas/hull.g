# SPDX-License-Identifier: MIT
# An edge function over the hull of a packet, in units of the greatest magnitude of a term of its rays. A term is c + r x,
# |x| <= 1, with the middle c and the radius r of its interval; the radius as computed exceeds r by what the middle is
# off, but for underflow: so the first two goals are factors of r and of |c|. The sums over the middles and over the radii
# have a product, five sums and their difference or sum.

u = 1b-24;
slack = 1b-20;
of_radius = (1 + d1) * (1 + slack) * (1 + d2) * (1 + d3) - 1;
of_middle = (1 + d1) * 0.25 * slack * (1 + d2) * (1 + d3) - 1b-24;
lost = h1 + (h2 + h3) * (1 + d3);
sums = ((1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) - 1) * (1 + 2 * slack);

# The coefficients as they are, without the sums: p g of C and g, and a slope; a place and the moment (moment.g).
slope_term = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) - (1 + e1) * (1 + e2) * (1 + e3);
moment_term = 1.001 * ((1 + d1) * (1 + d2) - (1 + e1)) + (1 + e1) * 3.001 * u * y;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24 /\ |h1| <= 1b-150 /\ |h2| <= 1b-150 /\ |h3| <= 1b-150 /\ |y| <= 1
  ->
  of_radius >= 0 /\ of_middle >= 0 /\ |lost| <= 1b-148 /\ |sums| / u <= 7.001
  /\ |slope_term| / u <= 7.001 /\ |moment_term| / u <= 6.1 }
