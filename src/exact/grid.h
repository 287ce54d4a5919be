/* SPDX-License-Identifier: MIT */
/*
 * Exact signs for coordinates that all lie on one grid: each is an integer below 2^61 times a common power of two. That
 * is so unless their magnitudes differ by more than some 2^37. On a grid, 64-bit integers and their products decide in
 * tens of nanoseconds; big_numbers.h takes hundreds.
 *
 * Each function returns 1 and sets its result, or returns 0 if there is no grid or the compiler has no 128-bit
 * integers. Coordinates are finite.
 */
#ifndef MLRT_EXACT_GRID_H
#define MLRT_EXACT_GRID_H

#include "base/platform.h"
#include "exact/segment.h"
#include "exact/triangle.h"

#if MLRT_HAVE_INT128

/* The signs of e_ab, e_bc, e_ca in sign[]: an entry that is not 0 on entry is known and stays. */
int mlrt_grid_edge_signs(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int sign[3]);

/* *sign: the sign of (a - point) . n. */
int mlrt_grid_distance_sign(const struct mlrt_triangle *triangle, const float point[3], int *sign);

/* *sign: the sign of t(first) - t(second) at the planes of two triangles, neither parallel to the ray. */
int mlrt_grid_order(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                    const struct mlrt_triangle *second, int *sign);

/* quotient[]: t, u, v of a triangle that the ray hits, each with a relative error below 2^-49. */
int mlrt_grid_quotients(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, double quotient[3]);

#else
static inline int mlrt_has_no_grid(const void *first, ...)
{
    return (void)first, 0;
}
#define mlrt_grid_edge_signs    mlrt_has_no_grid
#define mlrt_grid_distance_sign mlrt_has_no_grid
#define mlrt_grid_order         mlrt_has_no_grid
#define mlrt_grid_quotients     mlrt_has_no_grid
#endif

#endif
