# SPDX-License-Identifier: MIT
# The filter of rays that go alone or lane by lane (trace/triangle_test.h): e_ca, e_ab, D and N are
# determinants of d and of differences of points. Of each the error relative to the magnitude of a product as computed;
# d are the roundings of a product, e those of the differences in it, f those of a bound, h underflow.

u = 1b-24;

# Product and difference of the cross product, product and two sums with the third vector; e of two differences, or
# three.
five = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5);
edge = five - (1 + e1) * (1 + e2);
distance = five - (1 + e1) * (1 + e2) * (1 + e3);

# D - e_ca - e_ab: two differences more.
third_edge = five * (1 + d6) * (1 + d7) - (1 + e1) * (1 + e2);

# Underflow, where the sums of magnitudes are up to 2^63: of a cross product's component, and of three products.
lost = 2 * h1 * (1 + d1) * 1b63 + 3 * h2;
lost_of_three = 3 * lost;

# The bounds as computed. S, G and H have two sums each, m S (G + H) + m G H a sum, a product and a sum, then m, the
# factor and the floor; S G H has two products. By components, s(D) and s(N) have a product, a sum, a product and two
# sums, then the factor and the floor, so fewer than m G H and S G H have here.
edge_bound = 11 * u * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8) * (1 + f9)
             * (1 + f10);
plane_bound = 16 * u * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8);
distance_bound = 12 * u * (1 + f1) * (1 + f2) * (1 + f3) * (1 + f4) * (1 + f5) * (1 + f6) * (1 + f7) * (1 + f8)
                 * (1 + f9) * (1 + f10);

# What is left for comparisons: less the rounding of N -+ E and D -+ W.
left_of_d = plane_bound - 7.001 * u - 1.001 * u;
left_of_n = distance_bound - 8.001 * u - 1.001 * u;

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24 /\ |d6| <= 1b-24 /\ |d7| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  /\ |f1| <= 1b-24 /\ |f2| <= 1b-24 /\ |f3| <= 1b-24 /\ |f4| <= 1b-24 /\ |f5| <= 1b-24 /\ |f6| <= 1b-24 /\ |f7| <= 1b-24
  /\ |f8| <= 1b-24 /\ |f9| <= 1b-24 /\ |f10| <= 1b-24
  /\ |h1| <= 1b-150 /\ |h2| <= 1b-150
  ->
  |edge| / u <= 7.001 /\ |third_edge| / u <= 9.001 /\ |distance| / u <= 8.001 /\ |lost_of_three| <= 1b-84
  /\ edge_bound / u >= 10.99 /\ left_of_d / u >= 7.9 /\ left_of_n / u >= 2.9 }
