/* SPDX-License-Identifier: MIT */
/*
 * Vectors of three doubles, DW lanes of each: the products that determinants consist of (exact/determinants.h). They
 * are fused in no instruction set, because the bits of shadow rays depend on each rounding (hits/shadow_ray.h).
 */
#ifndef MLRT_SIMD_DOUBLES_H
#define MLRT_SIMD_DOUBLES_H

#include "simd/simd.h"

MLRT_INLINE void cross_product_of_doubles(const vd a[3], const vd b[3], vd cross[3])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = d_sub(d_mul(a[i], b[j]), d_mul(a[j], b[i]));
    }
}

MLRT_INLINE vd dot_product_of_doubles(const vd a[3], const vd b[3])
{
    return d_add(d_add(d_mul(a[0], b[0]), d_mul(a[1], b[1])), d_mul(a[2], b[2]));
}

/* The dot product of the magnitudes of a, and b, which is a vector of sizes. */
MLRT_INLINE vd dot_product_of_sizes(const vd a[3], const vd b[3])
{
    return d_add(d_add(d_mul(d_abs(a[0]), b[0]), d_mul(d_abs(a[1]), b[1])), d_mul(d_abs(a[2]), b[2]));
}

/* The sum of the magnitudes of the components. */
MLRT_INLINE vd size_of_doubles(const vd a[3]) { return d_add(d_add(d_abs(a[0]), d_abs(a[1])), d_abs(a[2])); }

#endif
