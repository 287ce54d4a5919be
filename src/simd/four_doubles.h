/* SPDX-License-Identifier: MIT */
/*
 * Four doubles in plain C, for instruction sets whose vectors are shorter: three coordinates and a fourth lane that is
 * arbitrary, or four numbers of one ray.
 */
#ifndef MLRT_FOUR_DOUBLES_H
#define MLRT_FOUR_DOUBLES_H

#include <math.h>
#include <stddef.h>

#include "base/platform.h"

typedef struct {
    double x[4];
} d4;
MLRT_INLINE d4 d4_set(double a, double b, double c, double d) { return (d4){{a, b, c, d}}; }
/* all lanes are lane i of a */
MLRT_INLINE d4 d4_lane(d4 a, int i) { return d4_set(a.x[i], a.x[i], a.x[i], a.x[i]); }
/* p[0], p[step], p[2 * step]; the fourth lane is finite */
MLRT_INLINE d4 d4_three(const float *p, size_t step) { return d4_set(p[0], p[step], p[2 * step], 0); }
/* lanes 1, 2, 0; 3, 2, 1, 0; 1, 0, 0, 1 of a */
MLRT_INLINE d4 d4_next(d4 a) { return d4_set(a.x[1], a.x[2], a.x[0], a.x[3]); }
MLRT_INLINE d4 d4_reversed(d4 a) { return d4_set(a.x[3], a.x[2], a.x[1], a.x[0]); }
MLRT_INLINE d4 d4_inside_out(d4 a) { return d4_set(a.x[1], a.x[0], a.x[0], a.x[1]); }
/* lane 0 of a, the others of b */
MLRT_INLINE d4 d4_first_of(d4 a, d4 b) { return d4_set(a.x[0], b.x[1], b.x[2], b.x[3]); }
MLRT_INLINE d4 d4_mul(d4 a, d4 b) { return d4_set(a.x[0] * b.x[0], a.x[1] * b.x[1], a.x[2] * b.x[2], a.x[3] * b.x[3]); }
MLRT_INLINE d4 d4_add(d4 a, d4 b) { return d4_set(a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2], a.x[3] + b.x[3]); }
MLRT_INLINE d4 d4_sub(d4 a, d4 b) { return d4_set(a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2], a.x[3] - b.x[3]); }
MLRT_INLINE d4 d4_inverse(d4 a) { return d4_set(1 / a.x[0], 1 / a.x[1], 1 / a.x[2], 1 / a.x[3]); }
MLRT_INLINE d4 d4_abs(d4 a) { return d4_set(fabs(a.x[0]), fabs(a.x[1]), fabs(a.x[2]), fabs(a.x[3])); }
/* the sums of lanes 0 .. 2 of a, b, c and d */
MLRT_INLINE d4 d4_sums(d4 a, d4 b, d4 c, d4 d)
{
    return d4_set(a.x[0] + a.x[1] + a.x[2], b.x[0] + b.x[1] + b.x[2], c.x[0] + c.x[1] + c.x[2],
                  d.x[0] + d.x[1] + d.x[2]);
}
MLRT_INLINE unsigned d4_lt(d4 a, d4 b)
{
    return (unsigned)((a.x[0] < b.x[0]) | (a.x[1] < b.x[1]) << 1 | (a.x[2] < b.x[2]) << 2 | (a.x[3] < b.x[3]) << 3);
}
/* Rounds b to four floats at p, which is aligned to 16. Returns the lanes where a rounds to the same float. */
MLRT_INLINE unsigned d4_round(float *p, d4 a, d4 b)
{
    unsigned same = 0;
    for (int i = 0; i < 4; ++i) {
        p[i] = (float)b.x[i];
        same |= (unsigned)((float)a.x[i] == p[i]) << i;
    }
    return same;
}

#endif
