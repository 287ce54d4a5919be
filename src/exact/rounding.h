/* SPDX-License-Identifier: MIT */
/* How far rounding in double is off; and rounding to float, up or down, so that bounds remain bounds. */
#ifndef MLRT_EXACT_ROUNDING_H
#define MLRT_EXACT_ROUNDING_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* u of double: the greatest error of a rounding, relative to what is rounded. */
#define MLRT_UNIT_ROUNDOFF 0x1p-53

/* The largest float below `a`, which may be infinite. -inf stays. */
static inline float mlrt_next_down(float a)
{
    uint32_t bits;
    memcpy(&bits, &a, sizeof bits);
    if (a == 0) {
        bits = 0x80000001u;
    } else if (a > 0) {
        --bits;
    } else if (a >= -FLT_MAX) {
        ++bits;
    }
    memcpy(&a, &bits, sizeof a);
    return a;
}

/* The largest float <= a. `a` is not a NaN. */
static inline float mlrt_float_down(double a)
{
    float nearest = a > FLT_MAX ? (isinf(a) ? (float)a : FLT_MAX) : (float)a;
    return nearest > a ? mlrt_next_down(nearest) : nearest;
}

/* The smallest float >= a. `a` is not a NaN. */
static inline float mlrt_float_up(double a)
{
    return -mlrt_float_down(-a);
}

#endif
