/* SPDX-License-Identifier: MIT */
/*
 * The determinants of the hit rule: see determinants.h.
 */
#include "exact/determinants.h"

MLRT_NOINLINE struct mlrt_crossing mlrt_cross_plane(const float origin[3], const float direction[3],
                                                    const struct mlrt_triangle *triangle)
{
    const struct mlrt_operands operands = mlrt_load_operands(origin, direction, triangle->v[0], 1);
    return mlrt_measure_crossing(&operands);
}

void mlrt_exact_vector_of(const float v[3], struct mlrt_exact_vector *result)
{
    for (int k = 0; k < 3; ++k) mlrt_exact_from_double(v[k], &result->x[k]);
}

void mlrt_exact_vector_between(const float from[3], const float to[3], struct mlrt_exact_vector *result)
{
    for (int k = 0; k < 3; ++k) mlrt_exact_from_difference(to[k], from[k], &result->x[k]);
}

void mlrt_exact_cross_component(const struct mlrt_exact_vector *v, const struct mlrt_exact_vector *w, int k,
                                struct mlrt_exact *result)
{
    int i = (k + 1) % 3, j = (k + 2) % 3;
    struct mlrt_exact plus, minus;
    mlrt_exact_multiply(&v->x[i], &w->x[j], &plus);
    mlrt_exact_multiply(&v->x[j], &w->x[i], &minus);
    mlrt_exact_subtract(&plus, &minus, result);
}

static void exact_cross(const struct mlrt_exact_vector *v, const struct mlrt_exact_vector *w,
                        struct mlrt_exact_vector *result)
{
    for (int k = 0; k < 3; ++k) mlrt_exact_cross_component(v, w, k, &result->x[k]);
}

void mlrt_exact_dot(const struct mlrt_exact_vector *v, const struct mlrt_exact_vector *w, struct mlrt_exact *result)
{
    struct mlrt_exact product[3], sum;
    for (int k = 0; k < 3; ++k) mlrt_exact_multiply(&v->x[k], &w->x[k], &product[k]);
    mlrt_exact_add(&product[0], &product[1], &sum);
    mlrt_exact_add(&sum, &product[2], result);
}

void mlrt_exact_edge(const struct mlrt_ray_segment *ray, const float vertex_i[3], const float vertex_j[3],
                     struct mlrt_exact *result)
{
    struct mlrt_exact_vector direction, to_i, edge, moment;
    mlrt_exact_vector_of(ray->direction, &direction);
    mlrt_exact_vector_between(ray->origin, vertex_i, &to_i);
    mlrt_exact_vector_between(vertex_i, vertex_j, &edge);
    exact_cross(&direction, &to_i, &moment);
    mlrt_exact_dot(&moment, &edge, result);
}

void mlrt_exact_normal(const struct mlrt_triangle *triangle, struct mlrt_exact_vector *result)
{
    struct mlrt_exact_vector ab, ac;
    mlrt_exact_vector_between(triangle->v[0], triangle->v[1], &ab);
    mlrt_exact_vector_between(triangle->v[0], triangle->v[2], &ac);
    exact_cross(&ab, &ac, result);
}

void mlrt_exact_crossing(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, struct mlrt_exact *d,
                         struct mlrt_exact *n)
{
    struct mlrt_exact_vector normal, direction, to_a;
    mlrt_exact_normal(triangle, &normal);
    mlrt_exact_vector_of(ray->direction, &direction);
    mlrt_exact_vector_between(ray->origin, triangle->v[0], &to_a);
    mlrt_exact_dot(&direction, &normal, d);
    mlrt_exact_dot(&to_a, &normal, n);
}

int mlrt_exact_sign_of_difference(const struct mlrt_exact *first, const struct mlrt_exact *second_factor,
                                  const struct mlrt_exact *second, const struct mlrt_exact *first_factor)
{
    struct mlrt_exact plus, minus, difference;
    mlrt_exact_multiply(first, second_factor, &plus);
    mlrt_exact_multiply(second, first_factor, &minus);
    mlrt_exact_subtract(&plus, &minus, &difference);
    return difference.sign;
}
