/* SPDX-License-Identifier: MIT */
/*
 * The judge of every hit: exact signs of the expressions in the hit rule (mlrt.h, "Answers"), for any finite floats.
 *
 * Each function first computes in double, with a bound on the rounding error, and decides if the sign is certain. Else
 * integers decide (integers.h). So the result is always that of real arithmetic, and nearly always takes a few dozen
 * operations in double.
 *
 * For all functions, coordinates are finite, the direction is not zero, 0 <= t_min < t_max, and triangles have an area
 * (mlrt_triangle_has_area), unless a function says that it allows less. `counters` (may be NULL) count the decisions
 * that exact arithmetic took.
 */
#ifndef MLRT_EXACT_PREDICATE_H
#define MLRT_EXACT_PREDICATE_H

#include <math.h>
#include <stdint.h>

#include "exact/segment.h"
#include "exact/triangle.h"

static inline int mlrt_triangle_is_finite(const struct mlrt_triangle *triangle)
{
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            if (!isfinite(triangle->v[i][k])) return 0;
    }
    return 1;
}

/* 1 if (b - a) x (c - a) is not exactly zero. The vertices must be finite. */
int mlrt_triangle_has_area(const struct mlrt_triangle *triangle);

/* Rule R2: 1 if the ray hits the triangle at a t in (t_min, t_max]. Allows triangles without area: 0. */
int mlrt_hits_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                       mlrt_counters *counters);

/*
 * For a triangle in a plane across an axis, and a ray not parallel to it: sets *sign to the sign of (its t) - t, where
 * t >= 0, by exact arithmetic in double, and returns 1. Returns 0 for other triangles and rays.
 */
int mlrt_reaches_flat(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float t, int *sign);

/*
 * Rule R6, for a triangle that the ray hits: 1 if the ray, with t_max = inf, still hits it when its origin is moved by
 * (e, e^2, e^3), for every e > 0 that is small enough.
 */
int mlrt_crosses_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle);

/*
 * Rule R3: the sign of t(first) - t(second), where the ray's line crosses the planes of the two triangles. Neither
 * plane may be parallel to the ray. t_min and t_max do not matter.
 */
int mlrt_compare_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                          const struct mlrt_triangle *second, mlrt_counters *counters);

/* 1 if the triangles lie in the same plane: then every ray that hits both hits them at the same t. */
int mlrt_share_plane(const struct mlrt_triangle *first, const struct mlrt_triangle *second);

/*
 * The sign of (point - a) . n: +1 on the side that the normal points to, 0 in the plane, -1 on the other side. Allows
 * triangles without area: 0.
 */
int mlrt_side_of_plane(const struct mlrt_triangle *triangle, const float point[3]);

/* The same for the point `from` + `by`, a sum that is not rounded. */
int mlrt_side_of_sum(const struct mlrt_triangle *triangle, const float from[3], const float by[3]);

/* The sign of d . n for a direction d. Allows triangles without area: 0. */
int mlrt_facing(const struct mlrt_triangle *triangle, const float direction[3]);

/* The same for the direction along an axis: the sign of that component of n. */
int mlrt_facing_axis(const struct mlrt_triangle *triangle, int axis);

#endif
