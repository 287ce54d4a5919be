/* SPDX-License-Identifier: MIT */
/*
 * The hit rule as traversal uses it: how a triangle that is offered changes the nearest hit so far (R2, R3).
 * predicate.h decides; the floats around t that are kept here save most comparisons.
 */
#ifndef MLRT_EXACT_NEAREST_H
#define MLRT_EXACT_NEAREST_H

#include "exact/predicate.h"
#include "exact/quotients.h"

/* The nearest hit so far. Before the first hit, lo = hi = t_max. */
struct mlrt_nearest {
    uint32_t triangle; /* its number, or MLRT_NONE */
    float lo;          /* lo <= t <= hi */
    float hi;
};

/*
 * Offers triangle `number` to a ray (rules R2, R3). If the ray hits it before *nearest, sets *nearest to it and returns
 * 1; else returns 0.
 */
static inline int mlrt_offer_triangle(const struct mlrt_triangles *triangles, const struct mlrt_ray_segment *ray,
                                      uint32_t number, struct mlrt_nearest *nearest, mlrt_counters *counters)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(triangles, number);
    if (!mlrt_hits_triangle(ray, &triangle, counters)) return 0;
    float lo, hi;
    mlrt_bound_distance(ray, &triangle, &lo, &hi);
    if (nearest->triangle != MLRT_NONE) {
        if (lo > nearest->hi) return 0;
        if (!(hi < nearest->lo)) {
            const struct mlrt_triangle other = mlrt_triangle_at(triangles, nearest->triangle);
            const int order = mlrt_compare_distance(ray, &triangle, &other, counters);
            if (order > 0 || (order == 0 && number > nearest->triangle)) return 0;
        }
    }
    nearest->triangle = number;
    nearest->lo = lo;
    nearest->hi = hi;
    return 1;
}

#endif
