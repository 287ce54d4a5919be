/* SPDX-License-Identifier: MIT */
/*
 * Sets of triangles on their way into leaves, as the builder of the hierarchy has them, and what they cost.
 */
#ifndef MLRT_BVH_SET_H
#define MLRT_BVH_SET_H

#include <stdint.h>
#include <string.h>

#include "base/platform.h"

/* A box as two f4; what is in the fourth places does not matter, and is no NaN that arithmetic must wait for. */
struct mlrt_quad_box {
    MLRT_ALIGNED(16) float lo[4];
    MLRT_ALIGNED(16) float hi[4];
};

/*
 * A triangle, or a part of one, to be put into a leaf: its box, and in the fourth place of lo the bits of its number |
 * 2^30. So that place is a float of at least 2, no denormal, and arithmetic on all four places runs at full speed.
 */
#define MLRT_REFERENCE_MARK 0x40000000u

static inline uint32_t mlrt_reference_triangle(const struct mlrt_quad_box *reference)
{
    uint32_t bits;
    memcpy(&bits, &reference->lo[3], sizeof bits);
    return bits & ~MLRT_REFERENCE_MARK;
}

/*
 * What a ray that meets a node or leaf costs, in units of what a node costs: it looks at all sixteen children in one
 * step, and at all triangles of a leaf nearly so.
 */
struct mlrt_bvh_costs {
    float node;
    float leaf;     /* of a leaf at all */
    float quad;     /* of each four places of it */
    float triangle; /* of each triangle in it */
};

/* A set of references: those from `first` on. */
struct mlrt_bvh_set {
    struct mlrt_quad_box box;     /* of all boxes */
    struct mlrt_quad_box centres; /* of all centres, see split.c */
    uint32_t first;
    uint32_t count;
};

#endif
