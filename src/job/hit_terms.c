/* SPDX-License-Identifier: MIT */
/*
 * The cached terms of t, u and v: see hit_terms.h. Formulas and widths are those of hits/hit_numbers.h, for one
 * triangle and one origin.
 */
#include "job/hit_terms.h"

#include <math.h>
#include <string.h>

#include "exact/quotients.h"

static void subtract(const float a[3], const float b[3], double difference[3])
{
    for (int k = 0; k < 3; ++k) difference[k] = (double)a[k] - b[k];
}

static void cross_product(const double a[3], const double b[3], double cross[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = a[i] * b[j] - a[j] * b[i];
    }
}

static double size_of(const double a[3])
{
    return fabs(a[0]) + fabs(a[1]) + fabs(a[2]);
}

void mlrt_set_plane_terms(const struct mlrt_triangle *triangle, struct mlrt_hit_terms *terms)
{
    double *term = terms->term, *side = term + MLRT_HIT_SIDE;
    for (int k = 0; k < 3; ++k) term[MLRT_HIT_CORNER + k] = triangle->v[0][k];
    subtract(triangle->v[2], triangle->v[0], side);
    subtract(triangle->v[0], triangle->v[1], side + 3);
    for (int i = 0; i < 2; ++i) term[MLRT_HIT_SIDE_SIZE + i] = size_of(side + 3 * i);
    cross_product(side, side + 3, term + MLRT_HIT_NORMAL);
    term[MLRT_HIT_NORMAL_SIZE] = term[MLRT_HIT_SIDE_SIZE] * term[MLRT_HIT_SIDE_SIZE + 1];
    terms->origin[0] = NAN;
}

void mlrt_set_origin_terms(const float origin[3], struct mlrt_hit_terms *terms)
{
    double *term = terms->term, p[3];
    const double *normal = term + MLRT_HIT_NORMAL;
    for (int k = 0; k < 3; ++k) p[k] = term[MLRT_HIT_CORNER + k] - origin[k];
    const double numerator_error = MLRT_NUMERATOR_ERROR * size_of(p), normal_size = term[MLRT_HIT_NORMAL_SIZE];
    const double n = p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2];
    term[MLRT_HIT_N] = n;
    term[MLRT_HIT_N_WIDTH] = numerator_error * normal_size + MLRT_DENOMINATOR_ERROR * MLRT_GREATEST_D_SIZE * fabs(n);
    for (int i = 0; i < 2; ++i) {
        cross_product(term + MLRT_HIT_SIDE + 3 * i, p, term + MLRT_HIT_EDGE + 3 * i);
        term[MLRT_HIT_EDGE_WIDTH + i] =
            numerator_error * term[MLRT_HIT_SIDE_SIZE + i] + MLRT_DENOMINATOR_ERROR * normal_size;
    }
    memcpy(terms->origin, origin, sizeof terms->origin);
}
