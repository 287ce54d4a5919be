# SPDX-License-Identifier: MIT
# The slope of a ray, d_j / |d_main|: one rounding and no underflow, for components that are not 0. Bound: u = 2^-24.

@rnd = float<ieee_32, ne>;
exact = across / pace;
slope = rnd(exact);

{ |across| in [1b-60, 1b60] /\ pace in [1b-60, 1b60] -> |slope -/ exact| <= 1b-24 /\ |slope| >= 1b-120 }
