/* SPDX-License-Identifier: MIT */
/* Triangles and boxes of floats, and the range of floats that the filters of traversal can compute with. */
#ifndef MLRT_EXACT_TRIANGLE_H
#define MLRT_EXACT_TRIANGLE_H

#include <math.h>

#include "mlrt.h"

/* A triangle as stored: the coordinates of a, b, c in turn, bit for bit as given. */
struct mlrt_triangle {
    float v[3][3];
};

/* 1 if the triangle lies in a plane across the axis. */
static inline int mlrt_is_across(const struct mlrt_triangle *triangle, uint32_t axis)
{
    return triangle->v[0][axis] == triangle->v[1][axis] && triangle->v[0][axis] == triangle->v[2][axis];
}

/*
 * The triangles of a tree by their numbers. They lie in order, or in the leaves of a hierarchy of boxes (bvh/node.h),
 * where `places` tells the place of each. Behind the leaves are quads of triangles that no leaf has as they were given.
 */
struct mlrt_triangles {
    const float *corners;   /* in order: 9 floats each. Else the corners of quads */
    const uint32_t *places; /* NULL = in order. Else, for each triangle: mlrt_pack_place */
    uint32_t given_quad;    /* from this quad on, corners are as they were given; before it, they are in units */
    float inverse_unit;     /* the factor that takes corners out of units */
};

/* Quads below this have a place that fits 32 bits. */
#ifndef MLRT_PLACE_QUADS
#define MLRT_PLACE_QUADS (1u << 26)
#endif

/* Place 0 .. 15 of a leaf whose 1 to 4 quads begin with quad `first`, or place 0 .. 3 of a quad behind the leaves. */
static inline uint32_t mlrt_pack_place(uint32_t first, uint32_t quad_count, uint32_t place)
{
    return first << 6 | place << 2 | (quad_count - 1);
}

/* The first quad of a place's leaf, how many quads that has, and the place in it. */
static inline uint32_t mlrt_first_quad_of(uint32_t packed)
{
    return packed >> 6;
}

static inline uint32_t mlrt_quad_count_of(uint32_t packed)
{
    return (packed & 3) + 1;
}

static inline uint32_t mlrt_place_in_leaf(uint32_t packed)
{
    return packed >> 2 & 15;
}

/* Coordinate i of a triangle is corner[i * row]. */
struct mlrt_corners {
    const float *corner;
    uint32_t row;
    int in_units; /* 1 = they are in units */
};

/* Where the corners of triangle `number` lie. */
static inline struct mlrt_corners mlrt_corners_of(const struct mlrt_triangles *triangles, uint32_t number)
{
    if (!triangles->places) return (struct mlrt_corners){triangles->corners + 9 * (size_t)number, 1, 0};
    const uint32_t packed = triangles->places[number], quad = mlrt_first_quad_of(packed);
    return (struct mlrt_corners){triangles->corners + 36 * (size_t)quad + mlrt_place_in_leaf(packed),
                                 4 * mlrt_quad_count_of(packed), quad < triangles->given_quad};
}

/* The triangle with these corners, bit for bit as it was given. */
struct mlrt_triangle mlrt_triangle_of(const struct mlrt_corners *from, float inverse_unit);

/* Triangle `number`, bit for bit as it was given. */
struct mlrt_triangle mlrt_triangle_at(const struct mlrt_triangles *triangles, uint32_t number);

struct mlrt_box {
    float lo[3];
    float hi[3];
};

/* Holds no point: each box that it is extended by is the result. */
static const struct mlrt_box MLRT_NO_BOX = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static inline void mlrt_extend_box(const float lo[3], const float hi[3], struct mlrt_box *box)
{
    for (int k = 0; k < 3; ++k) {
        if (lo[k] < box->lo[k]) box->lo[k] = lo[k];
        if (hi[k] > box->hi[k]) box->hi[k] = hi[k];
    }
}

/* Sets the corners of the box of a triangle. Adding 0 turns -0 into 0. */
static inline void mlrt_bound_triangle(const struct mlrt_triangle *triangle, float box_lo[3], float box_hi[3])
{
    for (int k = 0; k < 3; ++k) {
        const float a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        const float lo = a < b ? a : b, hi = a < b ? b : a;
        box_lo[k] = (c < lo ? c : lo) + 0.0f;
        box_hi[k] = (c > hi ? c : hi) + 0.0f;
    }
}

/* Magnitudes with which float arithmetic in traversal neither overflows nor underflows: these, and 0. */
#define MLRT_SAFE_MIN 0x1p-60f
#define MLRT_SAFE_MAX 0x1p60f

static inline int mlrt_is_float_safe(float a)
{
    float magnitude = a < 0 ? -a : a;
    return a == 0 || (magnitude >= MLRT_SAFE_MIN && magnitude <= MLRT_SAFE_MAX);
}

#endif
