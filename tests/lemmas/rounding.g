# SPDX-License-Identifier: MIT
# Fact 1 of docs/accuracy.md: what rounding to nearest does to a float. The other lemmas stand on it: there a rounded
# operation is (x op y) (1 + d) + h with |d| <= 2^-24 and |h| <= 2^-150, where h is 0 for sums and differences.

@rnd = float<ieee_32, ne>;

a = rnd(a_); # any two floats, whose sum may be denormal
b = rnd(b_);

{ |normal| in [1b-125, 1b127] /\ |small| <= 1b-125 /\ |a + b| <= 1b-125
  ->
  |rnd(normal) -/ normal| <= 1b-24 /\ |rnd(small) - small| <= 1b-150 /\ rnd(a + b) - (a + b) in [0, 0] }
