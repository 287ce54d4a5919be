# SPDX-License-Identifier: MIT
# The slope of a ray, d_j / |d_main|, where it is not 0: of a lane a quotient, with one rounding; of a hull a product
# with a reciprocal, with two, d1 and d2. Neither underflows. Bounds: u = 2^-24, and 2.001 u.

@rnd = float<ieee_32, ne>;
exact = across / pace;
reciprocal = 1 / pace;
of_product = (1 + d1) * (1 + d2) - 1;

{ |across| in [1b-149, 1b126] /\ pace in [1b-125, 1b125] /\ |exact| in [1b-100, 2] /\ |d1| <= 1b-24 /\ |d2| <= 1b-24
  ->
  |rnd(exact) -/ exact| <= 1b-24 /\ |rnd(reciprocal) -/ reciprocal| <= 1b-24 /\ |of_product| / 1b-24 <= 2.001 }
