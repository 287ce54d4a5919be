# SPDX-License-Identifier: MIT
# How far origins are away: A = 2 (S deep + X) (1 + 2^-20), deep = F + b, of the greatest slope S >= 1/2, intercept X
# and depth F from which a ray looks, and the greatest tau b at which one begins. It is not less than |o_main|, and not
# less than 2 |o_j|, o being differences as computed: |o_main| <= F (1 + e1) + b, as F is a sum with one rounding, and
# |o_j| <= (X + S |o_main| (1 + e2)) (1 + e3), as X is one, too. d are the roundings of A. Underflow is less than
# 2^-148.

slack = 1b-20;
factor = (1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + slack) * (1 + d5) - (1 + e1) * (1 + e2) * (1 + e3);

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |d4| <= 1b-24 /\ |d5| <= 1b-24
  /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
  ->
  factor >= 0 }
