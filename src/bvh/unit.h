/* SPDX-License-Identifier: MIT */
/*
 * The unit of a hierarchy of boxes. Its boxes and corners are coordinates times `unit`, a power of two, so that most
 * triangles have coordinates near 1 wherever a scene lies among the floats; few triangles that are far larger or
 * smaller do not move it. For usual scenes it is 1.
 *
 * The unit follows from the triangles alone. Rays are brought into units where a kernel loads them; t is the same in
 * both. Times a power of two a number stays what it was, unless it underflows or overflows:
 *
 *   Boxes are rounded outward. What lies farther out than MLRT_BVH_FAR has no bounds there: a low bound is at most FAR
 *   and otherwise -inf, a high one at least -FAR and otherwise inf.
 *
 *   A triangle is odd if one of its coordinates in units exceeds MLRT_SAFE_MAX or is not exact. Its corners in a leaf
 * are NaN, and whoever decides about it takes it from the tree.
 */
#ifndef MLRT_BVH_UNIT_H
#define MLRT_BVH_UNIT_H

#include <math.h>

#include "exact/rounding.h"
#include "scene/tree.h"

#define MLRT_BVH_FAR 0x1p62f

/* Sets the unit, from triangles. */
void mlrt_set_bvh_unit(struct mlrt_tree *tree);

/* Sets `whole` and `core`, from the unit, the triangles and the bounds of all that are not left out. */
void mlrt_set_bvh_extent(struct mlrt_tree *tree);

/* A low bound of a box, in units. */
static inline float mlrt_low_bound(double low)
{
    if (low > MLRT_BVH_FAR) return MLRT_BVH_FAR;
    return low < -MLRT_BVH_FAR ? -INFINITY : mlrt_float_down(low) + 0.0f;
}

static inline float mlrt_low_in_units(float x, float unit)
{
    return mlrt_low_bound((double)x * unit);
}

static inline float mlrt_high_in_units(float x, float unit)
{
    return 0.0f - mlrt_low_in_units(-x, unit);
}

/* Brings a triangle into units. Returns 0 if it is odd. */
static inline int mlrt_triangle_in_units(const struct mlrt_triangle *triangle, float unit,
                                         struct mlrt_triangle *in_units)
{
    int is_usual = 1;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            const float given = triangle->v[i][k], x = given * unit, size = x < 0 ? -x : x;
            is_usual &= size <= MLRT_SAFE_MAX && (double)x == (double)given * unit;
            in_units->v[i][k] = x;
        }
    }
    return is_usual;
}

/* 1 if no triangle can be odd: a unit of 1 is exact, and all coordinates are within MLRT_SAFE_MAX. */
static inline int mlrt_has_usual_triangles(const struct mlrt_tree *tree)
{
    int is_usual = tree->bvh.unit == 1;
    for (int k = 0; k < 3; ++k) {
        is_usual &= tree->bvh.whole.lo[k] >= -MLRT_SAFE_MAX && tree->bvh.whole.hi[k] <= MLRT_SAFE_MAX;
    }
    return is_usual;
}

#endif
