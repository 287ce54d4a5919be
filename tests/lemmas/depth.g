# SPDX-License-Identifier: MIT
# Bounds of t made of bounds of tau = t |d_main|, or the other way round: a quotient or product q >= 0, as computed
# fl(fl(fl(q) (1 - 2^-21)) - 2^-148), is not more than q, and with + in place of - not less. Each is q times 1 + a
# factor, and an offset that underflow and the floor make. d are roundings, h is underflow.

slack = 1b-21;
lower_factor = (1 + d1) * (1 - slack) * (1 + d2) * (1 + d3) - 1;
lower_offset = (h1 * (1 - slack) * (1 + d2) + h2 - 1b-148) * (1 + d3);
upper_factor = (1 + d1) * (1 + slack) * (1 + d2) * (1 + d3) - 1;
upper_offset = (h1 * (1 + slack) * (1 + d2) + h2 + 1b-148) * (1 + d3);

{ |d1| <= 1b-24 /\ |d2| <= 1b-24 /\ |d3| <= 1b-24 /\ |h1| <= 1b-150 /\ |h2| <= 1b-150
  ->
  lower_factor <= 0 /\ lower_offset <= 0 /\ upper_factor >= 0 /\ upper_offset >= 0 }
