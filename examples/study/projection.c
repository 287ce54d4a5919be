/* SPDX-License-Identifier: MIT */
/*
 * projection.c - Wald's test: the distance of the plane, then barycentric coordinates in a plane of two axes
 *
 * Once per triangle: k is the axis along which the normal N is longest, i and j are the two others in cyclic order, and
 *
 *     plane:   n_i = N_i / N_k, n_j = N_j / N_k, n_d = a . N / N_k
 *     weights: with b = C - A, c = B - A (projected) and the determinant b_i c_j - b_j c_i, the coefficients of the two
 *              affine functions of (h_i, h_j) that give the weights of B and C
 *
 * Then t = (n_d - o_k - n_i o_i - n_j o_j) / (d_k + n_i d_i + n_j d_j) and h = o + t d. The ray hits if both weights
 * are >= 0 and their sum is <= 1. Coefficients are computed in double and rounded to float once, which is more accurate
 * than float throughout.
 *
 * Based on: I. Wald, "Realtime Ray Tracing and Interactive Global Illumination", PhD thesis, Saarland University, 2004,
 * chapter 7 (the ray/triangle test of the OpenRT ray tracer), after D. Badouel, "An Efficient Ray-Polygon
 * Intersection", Graphics Gems, 1990.
 */
#include "traversal.h"
#include "vector.h"

#include <stdio.h>
#include <stdlib.h>

struct projection {
    float plane[3];  // n_i, n_j, n_d
    uint32_t axis;   // k
    float second[3]; // weight of B: second[0] h_i + second[1] h_j + second[2]
    float third[3];  // weight of C
};

static const uint32_t next_axis[4] = {1, 2, 0, 1};

static void project(const struct mlrt_triangle *triangle, struct projection *projection)
{
    double e1[3], e2[3], n[3];
    const float *a = triangle->v[0];
    subtract_double(triangle->v[1], a, e1);
    subtract_double(triangle->v[2], a, e2);
    cross_double(e1, e2, n);
    uint32_t k = 0;
    if (fabs(n[1]) > fabs(n[k])) k = 1;
    if (fabs(n[2]) > fabs(n[k])) k = 2;
    uint32_t i = next_axis[k], j = next_axis[k + 1];
    double determinant = e1[i] * e2[j] - e1[j] * e2[i];
    const double second[2] = {e2[j] / determinant, -e2[i] / determinant};
    const double third[2] = {-e1[j] / determinant, e1[i] / determinant};
    projection->axis = k;
    projection->plane[0] = (float)(n[i] / n[k]);
    projection->plane[1] = (float)(n[j] / n[k]);
    projection->plane[2] = (float)((a[i] * n[i] + a[j] * n[j] + a[k] * n[k]) / n[k]);
    for (int m = 0; m < 2; m++) {
        projection->second[m] = (float)second[m];
        projection->third[m] = (float)third[m];
    }
    projection->second[2] = (float)-(a[i] * second[0] + a[j] * second[1]);
    projection->third[2] = (float)-(a[i] * third[0] + a[j] * third[1]);
}

static int create(struct method_run *run)
{
    const struct mlrt_tree *tree = run->subject->kdtree;
    struct projection *table = malloc((tree->triangle_count ? tree->triangle_count : 1) * sizeof *table);
    run->state = table;
    if (!table) {
        fprintf(stderr, "not enough memory for %lu triangles\n", (unsigned long)tree->triangle_count);
        return 1;
    }
    for (uint32_t i = 0; i < tree->triangle_count; i++) project(&tree->triangles[i], &table[i]);
    return 0;
}

static void destroy(struct method_run *run)
{
    free(run->state);
}

MLRT_INLINE int test_projection(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                                const struct study_ray *ray, double *t)
{
    (void)triangles;
    const struct projection *p = (const struct projection *)table + number;
    uint32_t k = p->axis, i = next_axis[k], j = next_axis[k + 1];
    const float *o = ray->origin, *d = ray->direction;
    float across = d[k] + p->plane[0] * d[i] + p->plane[1] * d[j];
    float distance = (p->plane[2] - o[k] - p->plane[0] * o[i] - p->plane[1] * o[j]) / across;
    if (!(distance > 0 && distance < INFINITY)) return 0;
    float h_i = o[i] + distance * d[i], h_j = o[j] + distance * d[j];
    float u = h_i * p->second[0] + h_j * p->second[1] + p->second[2];
    if (!(u >= 0)) return 0;
    float v = h_i * p->third[0] + h_j * p->third[1] + p->third[2];
    if (!(v >= 0 && u + v <= 1)) return 0;
    *t = (double)distance;
    return 1;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    walk_all(run, rays, NULL, test_projection, answers);
}

const struct method projection_methods[] = {
    {"wald2004", "Wald 2004, projection, float", 0, 0, 0, create, trace, destroy},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
