/* SPDX-License-Identifier: MIT */
/*
 * The judge of every hit: exact signs of the expressions in the hit rule (mlrt.h, "Answers"), for any finite floats.
 *
 * Each function first computes in double, with a bound on the rounding error, and decides if the sign is certain. Else
 * exact arithmetic decides (grid.h, big_numbers.h). So the result is always that of real arithmetic, and almost always
 * takes a few dozen double operations.
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

/*
 * Offers a triangle in double alone. `other` is the triangle of the nearest hit so far (NULL: none), whose t lies in
 * [*lo, *hi]. Returns 1 if the ray certainly hits the triangle before that, and sets *lo and *hi to bounds of its t; 0
 * if it certainly does not; -1 if double cannot tell. is_inside: 1 = the ray is known to pass inside the edges.
 */
int mlrt_offer_in_double(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int is_inside,
                         const struct mlrt_triangle *other, float *lo, float *hi);

/* 1 if the triangles lie in the same plane: then every ray that hits both hits them at the same t. */
int mlrt_share_plane(const struct mlrt_triangle *first, const struct mlrt_triangle *second);

/*
 * Floats around the t of a triangle that the ray hits: 0 <= *lo <= t <= *hi <= inf, as close as double arithmetic can
 * tell. They are nearly always equal or neighbours; 0 and inf if the ray is too nearly parallel to the plane.
 */
void mlrt_bound_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float *lo,
                         float *hi);

/*
 * How quotients of determinants are enclosed in double, here and in hits/hit_numbers.h: the errors of numerator and
 * denominator relative to their sizes, and the least denominator, relative to its size, for which they hold. Derived
 * in predicate.c, "Quotients".
 */
#define MLRT_UNIT_ROUNDOFF     0x1p-53
#define MLRT_NUMERATOR_ERROR   (12 * MLRT_UNIT_ROUNDOFF)
#define MLRT_DENOMINATOR_ERROR (9 * MLRT_UNIT_ROUNDOFF)
#define MLRT_LEAST_DENOMINATOR 0x1p-44

/* Rule R5: t, u, v of a hit, each the exact quotient rounded once to the nearest float (ties to even). */
struct mlrt_hit_report {
    float t;
    float u;
    float v;
    int32_t facing; /* sign of d . n */
};

/*
 * Sets the fields of *report that `outputs` asks for (MLRT_OUTPUT_T, _UV, _FACING or-ed together), for a triangle that
 * the ray hits; so t, u, v are not negative. The other fields stay as they are.
 */
void mlrt_report_hit(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, uint32_t outputs,
                     struct mlrt_hit_report *report);

/*
 * The sign of (point - a) . n: +1 on the side that the normal points to, 0 in the plane, -1 on the other side. Allows
 * triangles without area: 0.
 */
int mlrt_side_of_plane(const struct mlrt_triangle *triangle, const float point[3]);

/* The same for the point `from` + `by`, a sum that is not rounded. */
int mlrt_side_of_sum(const struct mlrt_triangle *triangle, const float from[3], const float by[3]);

/* The sign of d . n for a direction d. Allows triangles without area: 0. */
int mlrt_facing(const struct mlrt_triangle *triangle, const float direction[3]);

#endif
