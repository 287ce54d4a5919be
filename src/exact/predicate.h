/* SPDX-License-Identifier: MIT */
/*
 * The judge of every hit: exact signs of the expressions in the hit rule (mlrt.h, "Answers"), for any finite floats.
 *
 * Each function first evaluates in double with a bound on its rounding error and answers if the sign is certain; what
 * is left goes to exact arithmetic (dyadic.h). So the answer is always that of real arithmetic, and almost always costs
 * a few dozen double operations.
 *
 * Everywhere here: coordinates are finite, the direction is not zero, 0 <= t_min < t_max, and triangles have an area
 * (mlrt_triangle_has_area), unless a function says that it copes with less. `counters`, if not NULL, learn of decisions
 * that went to exact arithmetic.
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
        for (int k = 0; k < 3; ++k) {
            if (!isfinite(triangle->v[i][k])) return 0;
        }
    }
    return 1;
}

/* 1 if (b - a) x (c - a) is not exactly zero. The vertices must be finite. */
int mlrt_triangle_has_area(const struct mlrt_triangle *triangle);

/* Rule R2: 1 if the ray hits the triangle at some t in (t_min, t_max]. Copes with triangles without area: 0. */
int mlrt_hits_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                       mlrt_counters *counters);

/*
 * For a triangle that lies in a plane across an axis, and a ray that is not parallel to it: *sign receives the sign of
 * its t less the given one (>= 0), by exact arithmetic in double. 0 for other triangles and rays.
 */
int mlrt_reaches_flat(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float t, int *sign);

/*
 * Rule R6, for a triangle that the ray hits: 1 if it would still be hit with the origin moved by (e, e^2, e^3) for
 * every e > 0 that is small enough, t_max aside.
 */
int mlrt_crosses_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle);

/*
 * Rule R3: the sign of t(first) - t(second), where the ray's line crosses the planes of the two triangles; neither may
 * be parallel to the ray. t_min and t_max do not matter.
 */
int mlrt_compare_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                          const struct mlrt_triangle *second, mlrt_counters *counters);

/*
 * What double tells of a triangle and the nearest hit so far, `other`, NULL if there is none, which lies between t = *lo
 * and *hi: 1 if it is hit and nearer, *lo and *hi being bounds of its t then; 0 if it is not; -1 if that is not certain.
 * `is_inside`: the ray is known to pass inside its edges.
 */
int mlrt_offer_in_double(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int is_inside,
                         const struct mlrt_triangle *other, float *lo, float *hi);

/* 1 if the triangles lie in one and the same plane: then no ray comes to one before the other. */
int mlrt_share_plane(const struct mlrt_triangle *first, const struct mlrt_triangle *second);

/*
 * The order of two triangles for all rays from a point: +1 if no ray hits the first before it meets the plane of the
 * second, -1 if each that hits the first and meets that plane does so before; 0 if neither is certain in double.
 */
int mlrt_order_of_triangles(const float from[3], const struct mlrt_triangle *first, const struct mlrt_triangle *second);

/*
 * Floats around the t of a triangle that the ray hits: 0 <= *lo <= t <= *hi <= inf, as close as double arithmetic shows
 * it: nearly always equal or neighbours, 0 and inf if the ray is so nearly in the plane that double cannot tell.
 */
void mlrt_bound_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float *lo,
                         float *hi);

/*
 * How double quotients of determinants are enclosed, here and in hit_numbers.h: the relative errors of
 * numerator and denominator, and the least denominator, relative to its size, that they are for. Derived in
 * predicate.c.
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
 * Of a triangle that the ray hits: so t, u, v are not negative. `outputs`: MLRT_OUTPUT_T, _UV, _FACING or-ed together;
 * what is not asked for is left as it is.
 */
void mlrt_report_hit(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, uint32_t outputs,
                     struct mlrt_hit_report *report);

/*
 * The sign of (point - a) . n: +1 on the side that the normal points to, 0 in the plane, -1 on the other side. Copes
 * with triangles without area: 0.
 */
int mlrt_side_of_plane(const struct mlrt_triangle *triangle, const float point[3]);

/* Likewise for the point `from` + `by`, a sum that is not rounded. */
int mlrt_side_of_sum(const struct mlrt_triangle *triangle, const float from[3], const float by[3]);

/* The sign of d . n for a direction. Copes with triangles without area: 0. */
int mlrt_facing(const struct mlrt_triangle *triangle, const float direction[3]);

#endif
