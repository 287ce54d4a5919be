/* SPDX-License-Identifier: MIT */
/*
 * A worker's cache of the terms of t, u and v that all rays share that hit one triangle, in double. It pays because the
 * next packets hit the same triangles if these are large. hits/hit_numbers.h has the formulas.
 */
#ifndef MLRT_JOB_HIT_TERMS_H
#define MLRT_JOB_HIT_TERMS_H

#include "exact/triangle.h"
#include "exact/vector.h"

/* The judge computes the numbers of a hit unless s(D) < 2^12 |D| is certain: see WIDTHS in hits/hit_numbers.h. */
#define MLRT_GREATEST_D_SIZE 0x1p12

/*
 * The terms of a triangle. A size is the sum of the magnitudes of a vector's components, or a product of such sums; a
 * width is a bound of the error of a quotient with D, times |D|.
 */
struct mlrt_hit_terms {
    /* For all rays. */
    struct mlrt_vector corner;
    struct mlrt_vector side[2]; /* c-a and a-b */
    double side_size[2];
    struct mlrt_vector normal;
    double normal_size;
    /* For rays from one origin: N, and the vectors whose dot products with d are e_ca and e_ab. */
    float origin[3];
    double n;
    double n_width;
    struct mlrt_vector edge[2];
    double edge_width[2]; /* to be multiplied with the size of d */
};

#define MLRT_HIT_TERMS_COUNT 16

/* The terms of triangle `number` are in entry number % MLRT_HIT_TERMS_COUNT. */
struct mlrt_hit_term_cache {
    uint32_t numbers[MLRT_HIT_TERMS_COUNT]; /* of triangles; MLRT_NONE = empty entry */
    struct mlrt_hit_terms entries[MLRT_HIT_TERMS_COUNT];
};

/* Sets the terms of a triangle, and of an origin. */
void mlrt_set_hit_terms(const struct mlrt_triangle *triangle, const float origin[3], struct mlrt_hit_terms *terms);

#endif
