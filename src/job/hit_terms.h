/* SPDX-License-Identifier: MIT */
/*
 * What rays that hit one triangle share of t, u and v, in double, as a worker keeps it: the next packets hit the same
 * triangles, if they are large. hit_numbers.h has the formulas.
 */
#ifndef MLRT_JOB_HIT_TERMS_H
#define MLRT_JOB_HIT_TERMS_H

#include "exact/triangle.h"

/* The judge has hits whose D is so many times smaller than its size, or more: this bounds the error of t. */
#define MLRT_GREATEST_D_SIZE 0x1p12

/* Which is which. A size is the sum of the magnitudes of a vector's components, or a product of such sums; a width is
 * what a quotient with D may be off by, times |D|. */
enum mlrt_hit_term {
    /* Of all rays: the first corner, the sides c-a and a-b, and the normal. */
    MLRT_HIT_CORNER,
    MLRT_HIT_SIDE = 3,
    MLRT_HIT_SIDE_SIZE = 9,
    MLRT_HIT_NORMAL = 11,
    MLRT_HIT_NORMAL_SIZE = 14,
    /* Of rays from one origin: N, and the vectors of e_ca and e_ab before their product with d; so are their widths. */
    MLRT_HIT_N,
    MLRT_HIT_N_WIDTH,
    MLRT_HIT_EDGE,
    MLRT_HIT_EDGE_WIDTH = MLRT_HIT_EDGE + 6,
    MLRT_HIT_TERM_COUNT = MLRT_HIT_EDGE_WIDTH + 2
};

struct mlrt_hit_terms {
    double term[MLRT_HIT_TERM_COUNT];
    float origin[3]; /* of the rays from one origin; NaN = none */
};

#define MLRT_HIT_TERMS_COUNT 16

/* Those that were wanted last: entry number % MLRT_HIT_TERMS_COUNT. */
struct mlrt_hit_term_cache {
    uint32_t numbers[MLRT_HIT_TERMS_COUNT]; /* of triangles; MLRT_NONE = empty entry */
    struct mlrt_hit_terms entries[MLRT_HIT_TERMS_COUNT];
};

/* The terms of a triangle; those of an origin are there no more. */
void mlrt_set_plane_terms(const struct mlrt_triangle *triangle, struct mlrt_hit_terms *terms);

/* Those of an origin. */
void mlrt_set_origin_terms(const float origin[3], struct mlrt_hit_terms *terms);

#endif
