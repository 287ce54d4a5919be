/* SPDX-License-Identifier: MIT */
/*
 * Exact signs where all coordinates at hand lie on one grid: multiples of a power of two, less than 2^61 of them. That
 * is so unless magnitudes differ by more than some 2^37, and then 64-bit integers and their products decide in tens of
 * nanoseconds what dyadic.h would in hundreds.
 *
 * Each function returns 1 and sets its result, or returns 0: no grid, or a compiler without 128-bit integers.
 * Coordinates are finite.
 */
#ifndef MLRT_EXACT_GRID_H
#define MLRT_EXACT_GRID_H

#include "exact/segment.h"
#include "exact/triangle.h"

/* The signs of e_ab, e_bc, e_ca: those that are 0 in sign[] are worked out, the others are known. */
int mlrt_grid_edge_signs(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int sign[3]);

/* 1 in *meets if the ray's line goes through the point, else 0. */
int mlrt_grid_meets_point(const struct mlrt_ray_segment *ray, const float point[3], int *meets);

/* The sign of (a - point) . n. */
int mlrt_grid_distance_sign(const struct mlrt_triangle *triangle, const float point[3], int *sign);

/* The sign of t(first) - t(second) at the planes of two triangles, neither parallel to the ray. */
int mlrt_grid_order(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                    const struct mlrt_triangle *second, int *sign);

/* t, u, v of a triangle that the ray hits, each with a relative error below 2^-49. */
int mlrt_grid_quotients(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, double quotient[3]);

#endif
