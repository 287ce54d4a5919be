/* SPDX-License-Identifier: MIT */
/*
 * The cached terms of t, u and v: see hit_terms.h. Formulas and widths are those of hits/hit_numbers.h, for one
 * triangle and one origin.
 */
#include "job/hit_terms.h"

#include <math.h>
#include <string.h>

#include "exact/quotients.h"

void mlrt_set_hit_terms(const struct mlrt_triangle *triangle, const float origin[3], struct mlrt_hit_terms *terms)
{
    const struct mlrt_vector a = mlrt_vector_at(triangle->v[0], 1), p = mlrt_subtract(a, mlrt_vector_at(origin, 1));
    const double p_error = MLRT_NUMERATOR_ERROR * mlrt_size_of(p);
    terms->corner = a;
    terms->side[0] = mlrt_subtract(mlrt_vector_at(triangle->v[2], 1), a);
    terms->side[1] = mlrt_subtract(a, mlrt_vector_at(triangle->v[1], 1));
    for (int i = 0; i < 2; ++i) terms->side_size[i] = mlrt_size_of(terms->side[i]);
    terms->normal = mlrt_cross(terms->side[0], terms->side[1]);
    terms->normal_size = terms->side_size[0] * terms->side_size[1];
    terms->n = mlrt_dot(p, terms->normal);
    terms->n_width = p_error * terms->normal_size + MLRT_DENOMINATOR_ERROR * MLRT_GREATEST_D_SIZE * fabs(terms->n);
    for (int i = 0; i < 2; ++i) {
        terms->edge[i] = mlrt_cross(terms->side[i], p);
        terms->edge_width[i] = p_error * terms->side_size[i] + MLRT_DENOMINATOR_ERROR * terms->normal_size;
    }
    memcpy(terms->origin, origin, sizeof terms->origin);
}
