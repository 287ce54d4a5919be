/* SPDX-License-Identifier: MIT */
/*
 * The hit rule in integers, for the decisions that double cannot make: exact for any finite floats, rays and triangles
 * as predicate.h has them. Nothing is allocated, and nothing overflows.
 */
#ifndef MLRT_EXACT_INTEGERS_H
#define MLRT_EXACT_INTEGERS_H

#include "exact/segment.h"
#include "exact/triangle.h"

/* Sets those of the signs of e_ab, e_bc, e_ca that are 0 on entry. Those that are not 0 are known and stay. */
void mlrt_exact_edge_signs(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int sign[3]);

/* The sign of the first component of d x (v_j - v_i) that is not 0, for the edge from vertex i to the next. Else 0. */
int mlrt_exact_edge_direction(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int i);

/* The sign of N - t D, for t >= 0 and any direction, 0 too. */
int mlrt_exact_sign_beyond(const float origin[3], const float direction[3], const struct mlrt_triangle *triangle,
                           float t);

/* The sign of t(first) - t(second) at the planes of two triangles, neither parallel to the ray. */
int mlrt_exact_order(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                     const struct mlrt_triangle *second);

/* As mlrt_report_hit (quotients.h). */
void mlrt_exact_report(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, uint32_t outputs,
                       mlrt_hit *hit);

#endif
