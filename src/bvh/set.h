/* SPDX-License-Identifier: MIT */
/* References to triangles on their way into leaves, sets of references, and the costs of nodes and leaves. */
#ifndef MLRT_BVH_SET_H
#define MLRT_BVH_SET_H

#include <stdint.h>
#include <string.h>

#include "base/platform.h"

/* A box as two f4. The fourth elements do not matter, but should be normal floats or 0, so that arithmetic is fast. */
struct mlrt_quad_box {
    MLRT_ALIGNED(16) float lo[4];
    MLRT_ALIGNED(16) float hi[4];
};

/*
 * A reference is the box of a triangle, or of a part of one, that is to be put into a leaf. The fourth element of its
 * lo has the bits of the triangle's number | 2^30: as a float its magnitude is at least 2, not denormal, so arithmetic
 * on all four elements runs at full speed. Of the parts of a triangle all but one are copies, with one bit more: the
 * leaf of the other is the triangle's place (places.h).
 */
#define MLRT_REFERENCE_MARK 0x40000000u
#define MLRT_REFERENCE_COPY 0x80000000u

/* The number of a reference's triangle, and MLRT_REFERENCE_COPY if it is a copy. */
static inline uint32_t mlrt_reference_word(const struct mlrt_quad_box *reference)
{
    uint32_t bits;
    memcpy(&bits, &reference->lo[3], sizeof bits);
    return bits & ~MLRT_REFERENCE_MARK;
}

/* The number of a reference's triangle. */
static inline uint32_t mlrt_reference_triangle(const struct mlrt_quad_box *reference)
{
    return mlrt_reference_word(reference) & ~MLRT_REFERENCE_COPY;
}

static inline void mlrt_mark_copy(struct mlrt_quad_box *reference)
{
    const uint32_t bits = mlrt_reference_word(reference) | MLRT_REFERENCE_MARK | MLRT_REFERENCE_COPY;
    memcpy(&reference->lo[3], &bits, sizeof bits);
}

/*
 * The costs for a ray that meets a node or a leaf, relative to a node's. All sixteen children of a node are tested in
 * one step, and all triangles of a leaf nearly so.
 */
struct mlrt_bvh_costs {
    float node;
    float leaf;     /* of each leaf, whatever its triangles */
    float triangle; /* of each triangle of a leaf */
};

/* The cost of a leaf of `count` triangles, not yet times its area. */
static inline float mlrt_bvh_leaf_cost(const struct mlrt_bvh_costs *costs, uint32_t count)
{
    return costs->leaf + costs->triangle * (float)count;
}

/* A set of references: `count` of them from `first` on. */
struct mlrt_bvh_set {
    struct mlrt_quad_box box;     /* of all boxes */
    struct mlrt_quad_box centres; /* of all centres (box.h) */
    uint32_t first;
    uint32_t count;
};

#endif
