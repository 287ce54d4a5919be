/* SPDX-License-Identifier: MIT */
/* Vectors in double. Their sums are in a fixed order, so that all that compute with them round alike. */
#ifndef MLRT_EXACT_VECTOR_H
#define MLRT_EXACT_VECTOR_H

#include <math.h>
#include <stddef.h>

#include "base/platform.h"

struct mlrt_vector {
    double x, y, z;
};

/* The vector whose components are floats, `step` of them apart. */
MLRT_INLINE struct mlrt_vector mlrt_vector_at(const float *first, size_t step)
{
    return (struct mlrt_vector){first[0], first[step], first[2 * step]};
}

MLRT_INLINE struct mlrt_vector mlrt_subtract(struct mlrt_vector v, struct mlrt_vector w)
{
    return (struct mlrt_vector){v.x - w.x, v.y - w.y, v.z - w.z};
}

MLRT_INLINE struct mlrt_vector mlrt_add(struct mlrt_vector v, struct mlrt_vector w)
{
    return (struct mlrt_vector){v.x + w.x, v.y + w.y, v.z + w.z};
}

MLRT_INLINE struct mlrt_vector mlrt_scale(struct mlrt_vector v, double factor)
{
    return (struct mlrt_vector){v.x * factor, v.y * factor, v.z * factor};
}

MLRT_INLINE struct mlrt_vector mlrt_cross(struct mlrt_vector v, struct mlrt_vector w)
{
    return (struct mlrt_vector){v.y * w.z - v.z * w.y, v.z * w.x - v.x * w.z, v.x * w.y - v.y * w.x};
}

MLRT_INLINE double mlrt_dot(struct mlrt_vector v, struct mlrt_vector w)
{
    return v.x * w.x + v.y * w.y + v.z * w.z;
}

/* The sum of the magnitudes of the components. */
MLRT_INLINE double mlrt_size_of(struct mlrt_vector v)
{
    return fabs(v.x) + fabs(v.y) + fabs(v.z);
}

/* ---- of arrays ---- */

MLRT_INLINE double mlrt_sum_of_magnitudes(const double a[3])
{
    return fabs(a[0]) + fabs(a[1]) + fabs(a[2]);
}

/* Sets `cross` to p x q, and `size` to what the error of each component is relative to. */
MLRT_INLINE void mlrt_cross_with_sizes(const double p[3], const double q[3], double cross[3], double size[3])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const double r = p[(k + 1) % 3] * q[(k + 2) % 3], s = p[(k + 2) % 3] * q[(k + 1) % 3];
        cross[k] = r - s;
        size[k] = fabs(r) + fabs(s);
    }
}

#endif
