/* SPDX-License-Identifier: MIT */
/*
 * pluecker.c - the side of each edge on which the ray passes, by Pluecker coordinates in float
 *
 * Coordinates are relative to the ray's origin, which keeps far more digits than coordinates of the world and makes the
 * ray's moment 0. Then the side of the edge from v_i to v_j is the sign of d . (v_i x v_j), the volume of a
 * tetrahedron. The ray hits if no two sides differ; the distance is that of the plane,
 *     (a . n) / (d . n) with n = (b - a) x (c - a).
 *
 * For two triangles that share an edge, its side is computed with the same roundings, and only the sign changes: so
 * there are no gaps at edges. Nothing is precomputed: a table of edges would have to hold coordinates of the world.
 *
 * Based on: J. Erickson, "Pluecker Coordinates", Ray Tracing News 10(3), 1997; J. Amanatides, K. Choi, "Ray Tracing
 * Triangular Meshes", Western Computer Graphics Symposium, 1997.
 */
#include "traversal.h"
#include "vector.h"

MLRT_INLINE float side(const float direction[3], const float from[3], const float to[3])
{
    float moment[3];
    cross_float(from, to, moment);
    return dot_float(direction, moment);
}

MLRT_INLINE int test_pluecker(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                              const struct study_ray *ray, double *t)
{
    (void)table;
    const struct mlrt_triangle *triangle = &triangles[number];
    float a[3], b[3], c[3], e1[3], e2[3], normal[3];
    subtract_float(triangle->v[0], ray->origin, a);
    subtract_float(triangle->v[1], ray->origin, b);
    subtract_float(triangle->v[2], ray->origin, c);
    float ab = side(ray->direction, a, b), bc = side(ray->direction, b, c), ca = side(ray->direction, c, a);
    if ((ab < 0 || bc < 0 || ca < 0) && (ab > 0 || bc > 0 || ca > 0)) return 0;
    subtract_float(triangle->v[1], triangle->v[0], e1);
    subtract_float(triangle->v[2], triangle->v[0], e2);
    cross_float(e1, e2, normal);
    float across = dot_float(ray->direction, normal);
    if (across == 0) return 0;
    *t = (double)(dot_float(a, normal) / across);
    return 1;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    walk_all(run, rays, NULL, test_pluecker, answers);
}

const struct method pluecker_methods[] = {
    {"pluecker", "Pluecker, float", 0, 0, 0, NULL, trace, NULL},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
