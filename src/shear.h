/* SPDX-License-Identifier: MIT */
/*
 * Rays of one direction, seen as rays from an apex.
 *
 * Let z be the depth of a point along a main axis, and q_j = p_j - S_j z its place in the other two, S the slopes of
 * the rays: a shear. All relative to a centre, and divided by a size that makes everything at hand smaller than 1. A
 * ray is a place (q_j, q_l) then. The projective map
 *
 *     (q_j, q_l, z)  ->  (1, q_j, q_l) / (1 - z)
 *
 * takes planes to planes, and rays to rays from the apex 0 with direction (1, q_j, q_l), where t = 1 / (1 - z) grows
 * with z. So what is for rays of one apex serves these too (kernels/bvh_leaf.h, bvh_tile.h), if it is given
 *
 *   - (q_j, q_l) for directions and slopes, and 1 / (1 - z) for depths and distances;
 *   - edge functions (a + b) x (b - a) of corners (1, q_j, q_l): a factor 1 / (1 - z) for each corner is left out,
 *     which is positive;
 *   - N' = n . s, where s = (1, S_j, S_l) before the shear, and D' = (1 - z(q)) N' = (N' - n . a) + n_j q_j + n_l q_l:
 *     the ray at q meets the plane n . (p - a) = 0 in z(q).
 *
 * Any hit of a ray is one of the opposite ray: where any hit will do depth grows against the rays of arrays, since then
 * they begin far away, all outside the scene, and end where they are.
 *
 * SIZE. At least twice as large as any |p_k - centre_k| of the scene, which so lies in |p_k| <= 1/2, |q_j| <= 1; and of
 * rays, |p_k| <= 1, |q_j| <= 2. Others go alone. So 1/2 <= 1 - z <= 3/2. The unit is 1 / scale, whatever that is
 * rounded to. Where rays of arrays begin outside the scene it grows by powers of two, lest each tile have its own.
 *
 * ERRORS, u = 2^-24, in that unit. S has 1 rounding, |S_j| <= 1. For a corner, p has an error of u, and q_j one of 3.5
 * u; for a ray, 2 u and 7 u. With g = b - a of the corners themselves, g'_j = g_j - S_j g_main has an error of u (2
 * |g_j| + 4 |g_main|), and
 *
 *     e' = (x_j - 2 q_j) g'_l - (x_l - 2 q_l) g'_j,   x = a + b, |x| <= 2
 *
 * is off by 23 u (|g'_j| + |g'_l|) because of x and q, by 6 u (2 |g_j| + 2 |g_l| + 8 |g_main|) because of g', and by 8
 * roundings of at most 6 (|g'_j| + |g'_l|): together by less than u (83 (|g_j| + |g_l|) + 190 |g_main|). Divided by 8
 * (|g_j| + |g_l|) + 18 |g_main| it is within EDGE_BOUND R, 11 u R (kernels/triangle_filter.h), R being at least 1.
 *
 * n has 6 roundings relative to its size, of which |n . s| is at most twice. N' so is off by 20 u, n . a by 10 u, and
 * D' with what n_j q_j adds by 84 u. All are divided by 8: so D' is within PLANE_BOUND R, 16 u R, by 5 u, and N' within
 * 3 u. Where a ray begins and ends is off by 11 u of 1 / (1 - z): 32 u |N'| are added to the bound of N', which then
 * holds for comparisons with these as they were computed.
 *
 * Outlines and places in the picture are moved apart by MLRT_SHEAR_SLACK, 16 u, each. That is for boxes, too, where the
 * sums are off by 3 u, and a place that becomes a length by 2 u |q_j|.
 *
 * Based on: P. Lacroute, M. Levoy, "Fast Volume Rendering Using a Shear-Warp Factorization of the Viewing
 * Transformation", 1994 (the shear).
 */
#ifndef MLRT_SHEAR_H
#define MLRT_SHEAR_H

#include "hit.h"

#define MLRT_SHEAR_SLACK 0x1p-20f

/* All of its members have 4 bytes, so that two can be compared as bytes. */
struct mlrt_shear {
    int32_t main_axis;
    float sign;     /* of along_main */
    float given[3]; /* the rays' direction, */
    float along[3]; /* that or its opposite: how depth grows */
    float centre[3];
    float slope[2]; /* along_j / |along_main| over axes main + 1, main + 2 */
    float size;
    float scale; /* 1 / size; 0: there is no shear, rays have an apex */
    float pace;  /* depth per t */
    float front; /* the whole scene is deeper than this */
};

struct mlrt_source;

/*
 * For rays of a source that have this direction, one of which begins at `origin`; a camera's, whose pictures should
 * have one shear, need not say where. `any`: any hit will do.
 */
void mlrt_make_shear(const struct mlrt_tree *tree, const struct mlrt_source *source, const float direction[3],
                     const float origin[3], int any, struct mlrt_shear *shear);

/* Turns the bounds of a ray's nearest hit into ones of 1 / (1 - z), */
void mlrt_shear_distance(const struct mlrt_shear *shear, const struct mlrt_ray_segment *ray,
                         struct mlrt_nearest *nearest);

/* and back. */
void mlrt_unshear_distance(const struct mlrt_shear *shear, const struct mlrt_ray_segment *ray,
                           struct mlrt_nearest *nearest);

#endif
