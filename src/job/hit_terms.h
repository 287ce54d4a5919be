/* SPDX-License-Identifier: MIT */
/*
 * A worker's cache of the terms of t, u and v that all rays share that hit one triangle, in double. It pays because the
 * next packets hit the same triangles if these are large. hits/hit_numbers.h has the formulas.
 */
#ifndef MLRT_JOB_HIT_TERMS_H
#define MLRT_JOB_HIT_TERMS_H

#include "exact/triangle.h"

/* The judge computes the numbers of hits whose D is not more than its size over this: that bounds the error of t. */
#define MLRT_GREATEST_D_SIZE 0x1p12

/*
 * Places of the terms. A size is the sum of the magnitudes of a vector's components, or a product of such sums; a
 * width is a bound of the error of a quotient with D, times |D|.
 */
enum mlrt_hit_term {
    /* For all rays: the first corner, the sides c-a and a-b, and the normal. */
    MLRT_HIT_CORNER,
    MLRT_HIT_SIDE = 3,
    MLRT_HIT_SIDE_SIZE = 9,
    MLRT_HIT_NORMAL = 11,
    MLRT_HIT_NORMAL_SIZE = 14,
    /*
     * For rays from one origin: N, and the vectors whose dot products with d are e_ca and e_ab. Their widths have to be
     * multiplied with the size of d.
     */
    MLRT_HIT_N,
    MLRT_HIT_N_WIDTH,
    MLRT_HIT_EDGE,
    MLRT_HIT_EDGE_WIDTH = MLRT_HIT_EDGE + 6,
    MLRT_HIT_TERM_COUNT = MLRT_HIT_EDGE_WIDTH + 2
};

struct mlrt_hit_terms {
    double term[MLRT_HIT_TERM_COUNT];
    float origin[3]; /* of the terms for one origin; NaN = not set */
};

#define MLRT_HIT_TERMS_COUNT 16

/* The terms of triangle `number` are in entry number % MLRT_HIT_TERMS_COUNT. */
struct mlrt_hit_term_cache {
    uint32_t numbers[MLRT_HIT_TERMS_COUNT]; /* of triangles; MLRT_NONE = empty entry */
    struct mlrt_hit_terms entries[MLRT_HIT_TERMS_COUNT];
};

/* Sets the terms of a triangle for all rays. Those for one origin become invalid. */
void mlrt_set_plane_terms(const struct mlrt_triangle *triangle, struct mlrt_hit_terms *terms);

/* Sets the terms for one origin. */
void mlrt_set_origin_terms(const float origin[3], struct mlrt_hit_terms *terms);

#endif
