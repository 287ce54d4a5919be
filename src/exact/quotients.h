/* SPDX-License-Identifier: MIT */
/*
 * The t, u and v of hits: between bounds, compared with other hits, and rounded to the nearest float. What predicate.h
 * says of its functions holds here, too.
 */
#ifndef MLRT_EXACT_QUOTIENTS_H
#define MLRT_EXACT_QUOTIENTS_H

#include <stdint.h>

#include "exact/rounding.h"
#include "exact/segment.h"
#include "exact/triangle.h"

/*
 * Floats around the t of a triangle that the ray hits: 0 <= *lo <= t <= *hi <= inf, as close as double arithmetic can
 * tell. They are nearly always equal or neighbours; 0 and inf if the ray is too nearly parallel to the plane.
 */
void mlrt_bound_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float *lo,
                         float *hi);

/*
 * How quotients of determinants are enclosed in double, here and in hits/hit_numbers.h: the errors of numerator and
 * denominator relative to their sizes, and the least denominator, relative to its size, for which they hold. Derived
 * in quotients.c.
 */
#define MLRT_NUMERATOR_ERROR   (12 * MLRT_UNIT_ROUNDOFF)
#define MLRT_DENOMINATOR_ERROR (9 * MLRT_UNIT_ROUNDOFF)
#define MLRT_LEAST_DENOMINATOR 0x1p-44

/*
 * Rule R5: sets t, u and v of a hit, each the exact quotient rounded once to the nearest float (ties to even), and
 * facing, as far as `outputs` asks for them (MLRT_OUTPUT_T, _UV, _FACING or-ed together). The ray must hit the
 * triangle; so t, u, v are not negative. The other fields stay as they are.
 */
void mlrt_report_hit(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, uint32_t outputs,
                     mlrt_hit *hit);

#endif
