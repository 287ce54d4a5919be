/* SPDX-License-Identifier: MIT */
/*
 * The unit of a hierarchy of boxes, a power of two. Boxes and corners in the hierarchy are coordinates times the unit
 * ("in units"): so the coordinates of most triangles are near 1, whatever the size of the scene. A few triangles that
 * are far larger or smaller do not change the unit. For usual scenes it is 1.
 *
 * The unit depends on the triangles alone. A kernel brings rays into units when it loads them; t is the same in both.
 * Multiplying by a power of two is exact unless the product underflows or overflows. There,
 *
 *   - boxes are rounded outward. Beyond MLRT_BVH_FAR there are no bounds: a low bound below -FAR is -inf, one above FAR
 *     is FAR; a high bound above FAR is inf, one below -FAR is -FAR.
 *
 *   - triangles are odd: those with a coordinate in units that exceeds MLRT_SAFE_MAX or is not exact. Their corners in
 *     leaves are NaN, and decisions about them use the vertices in the tree.
 */
#ifndef MLRT_BVH_UNIT_H
#define MLRT_BVH_UNIT_H

#include <math.h>

#include "exact/rounding.h"
#include "scene/tree.h"

#define MLRT_BVH_FAR 0x1p62f

/* Sets the unit of tree->bvh from the triangles. Returns the exponent of a typical coordinate. */
int mlrt_set_bvh_unit(struct mlrt_tree *tree);

/* Sets whole, core and reach (scene/reach.h) of tree->bvh from unit, that exponent, triangles, and tree->bounds. */
void mlrt_set_bvh_extent(struct mlrt_tree *tree, int typical);

/* The low bound of a box for a coordinate in units, rounded down. */
static inline float mlrt_low_bound(double low)
{
    if (low > MLRT_BVH_FAR) return MLRT_BVH_FAR;
    return low < -MLRT_BVH_FAR ? -INFINITY : mlrt_float_down(low) + 0.0f;
}

/* A bound in units, cut to 2 MLRT_BVH_FAR either way, so that areas computed from it are finite. */
static inline float mlrt_finite_bound(float bound)
{
    const float limit = 2 * MLRT_BVH_FAR;
    return bound < -limit ? -limit : bound > limit ? limit : bound;
}

/* Is an origin within the reach of boxes? */
static inline int mlrt_is_within_reach(const struct mlrt_bvh *bvh, const float origin[3])
{
    const float reach = bvh->reach, unit = bvh->unit;
    return fabsf(origin[0] * unit) <= reach && fabsf(origin[1] * unit) <= reach && fabsf(origin[2] * unit) <= reach;
}

static inline float mlrt_low_in_units(float x, float unit)
{
    return mlrt_low_bound((double)x * unit);
}

static inline float mlrt_high_in_units(float x, float unit)
{
    return 0.0f - mlrt_low_in_units(-x, unit);
}

/* 1 if a box lies within -limit .. limit along each axis. */
static inline int mlrt_is_within(const float lo[3], const float hi[3], float limit)
{
    for (int k = 0; k < 3; ++k)
        if (!(lo[k] >= -limit && hi[k] <= limit)) return 0;
    return 1;
}

/* Sets *in_units to the triangle in units. Returns 0 if it is odd. */
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

/* 1 if a triangle is odd. */
int mlrt_is_odd(const struct mlrt_tree *tree, uint32_t number);

#endif
