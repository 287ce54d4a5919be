/* SPDX-License-Identifier: MIT */
/*
 * Triangles and boxes of floats, and the range of floats that the filters of traversal can compute with.
 */
#ifndef MLRT_EXACT_TRIANGLE_H
#define MLRT_EXACT_TRIANGLE_H

#include "mlrt.h"

/* A triangle as stored: the coordinates of a, b, c in turn, bit for bit as given. */
struct mlrt_triangle {
    float v[3][3];
};

struct mlrt_box {
    float lo[3];
    float hi[3];
};

/* Magnitudes with which float arithmetic in traversal neither overflows nor underflows: these, and 0. */
#define MLRT_SAFE_MIN 0x1p-60f
#define MLRT_SAFE_MAX 0x1p60f

static inline int mlrt_is_float_safe(float a)
{
    float magnitude = a < 0 ? -a : a;
    return a == 0 || (magnitude >= MLRT_SAFE_MIN && magnitude <= MLRT_SAFE_MAX);
}

#endif
