/* SPDX-License-Identifier: MIT */
/*
 * moeller_trumbore.c - the test that most programs use, in float with and without its epsilon, and in double
 *
 * With the edges e1 = b - a and e2 = c - a and s = o - a, p = d x e2, q = s x e1, D = e1 . p:
 *     u = s . p / D,  v = d . q / D,  t = e2 . q / D;  a hit if u >= 0, v >= 0 and u + v <= 1.
 *
 * This is the variant that accepts hits from both sides. In float the edges are computed once per triangle and stored
 * with a: the bits are those of edges computed for each ray, with less work. In double they are computed for each ray
 * from the float corners, which take a third of the memory of a table of doubles. The epsilon is that of the paper's
 * code, 1e-6: a ray with |D| below it misses.
 *
 * Based on: T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", Journal of Graphics Tools 2(1),
 * 1997, sections 2 and 3.
 */
#include "traversal.h"
#include "vector.h"

#include <stdio.h>
#include <stdlib.h>

#define EPSILON 0.000001f

struct edges {
    float a[3];
    float e1[3];
    float e2[3];
};

static int create_table(struct method_run *run)
{
    const struct mlrt_tree *tree = run->subject->kdtree;
    struct edges *table = malloc((tree->triangle_count ? tree->triangle_count : 1) * sizeof *table);
    run->state = table;
    if (!table) {
        fprintf(stderr, "not enough memory for %lu triangles\n", (unsigned long)tree->triangle_count);
        return 1;
    }
    for (uint32_t i = 0; i < tree->triangle_count; i++) {
        const struct mlrt_triangle *triangle = &tree->triangles[i];
        for (int k = 0; k < 3; k++) table[i].a[k] = triangle->v[0][k];
        subtract_float(triangle->v[1], triangle->v[0], table[i].e1);
        subtract_float(triangle->v[2], triangle->v[0], table[i].e2);
    }
    return 0;
}

static void destroy_table(struct method_run *run)
{
    free(run->state);
}

MLRT_INLINE int test_float(const struct edges *edges, const struct study_ray *ray, float epsilon, double *t)
{
    float p[3], q[3], s[3];
    cross_float(ray->direction, edges->e2, p);
    float determinant = dot_float(edges->e1, p);
    if (epsilon > 0 ? determinant > -epsilon && determinant < epsilon : determinant == 0) return 0;
    float reciprocal = 1 / determinant;
    subtract_float(ray->origin, edges->a, s);
    float u = dot_float(s, p) * reciprocal;
    if (!(u >= 0 && u <= 1)) return 0;
    cross_float(s, edges->e1, q);
    float v = dot_float(ray->direction, q) * reciprocal;
    if (!(v >= 0 && u + v <= 1)) return 0;
    *t = (double)(dot_float(edges->e2, q) * reciprocal);
    return 1;
}

MLRT_INLINE int test_plain(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                           const struct study_ray *ray, double *t)
{
    (void)triangles;
    return test_float((const struct edges *)table + number, ray, 0, t);
}

MLRT_INLINE int test_epsilon(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                             const struct study_ray *ray, double *t)
{
    (void)triangles;
    return test_float((const struct edges *)table + number, ray, EPSILON, t);
}

MLRT_INLINE int test_double(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                            const struct study_ray *ray, double *t)
{
    (void)table;
    const struct mlrt_triangle *triangle = &triangles[number];
    double e1[3], e2[3], p[3], q[3], s[3];
    const double d[3] = {ray->direction[0], ray->direction[1], ray->direction[2]};
    subtract_double(triangle->v[1], triangle->v[0], e1);
    subtract_double(triangle->v[2], triangle->v[0], e2);
    cross_double(d, e2, p);
    double determinant = dot_double(e1, p);
    if (determinant == 0) return 0;
    double reciprocal = 1 / determinant;
    subtract_double(ray->origin, triangle->v[0], s);
    double u = dot_double(s, p) * reciprocal;
    if (!(u >= 0 && u <= 1)) return 0;
    cross_double(s, e1, q);
    double v = dot_double(d, q) * reciprocal;
    if (!(v >= 0 && u + v <= 1)) return 0;
    *t = dot_double(e2, q) * reciprocal;
    return 1;
}

static void trace_plain(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    walk_all(run, rays, NULL, test_plain, answers);
}

static void trace_epsilon(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    walk_all(run, rays, NULL, test_epsilon, answers);
}

static void trace_double(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    walk_all(run, rays, NULL, test_double, answers);
}

const struct method moeller_trumbore_methods[] = {
    {"mt_float", "Moeller-Trumbore, float", 0, 0, 0, create_table, trace_plain, destroy_table},
    {"mt_epsilon", "Moeller-Trumbore, float, epsilon 1e-6", 0, 0, 0, create_table, trace_epsilon, destroy_table},
    {"mt_double", "Moeller-Trumbore, double", 0, 0, 0, NULL, trace_double, NULL},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
