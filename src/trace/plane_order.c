/* SPDX-License-Identifier: MIT */
/*
 * The line in which the planes of two triangles meet, as an edge function. L14 in docs/accuracy.md, "Bundles", derives
 * its bound.
 *
 * WHAT IS COMPUTED. A ray meets the planes of triangles 1 and 2 at t_1 = N_1 / D_1 and t_2 = N_2 / D_2. Let
 * V_i = n_i . (a_i - w) be N at the waist. With the terms of a ray of a bundle (leaf.h),
 *
 *     F = N_1 D_2 - N_2 D_1 = (D_1 D_2) (t_1 - t_2)
 *
 * is C_z + s_j C_j + s_l C_l - x_j g_l + x_l g_j + m g_z, where C = V_1 n_2 - V_2 n_1 and g = n_2 x n_1: the edge
 * function of the line that both planes have in common. C and g cancel where the planes are close to each other, so
 * they are computed in double.
 *
 * ERRORS OF DOUBLES, v = 2^-53. From those of n and V (planes.h), C_k is off by less than 14.001 v of
 * T_k = s(V_1) size_2k + s(V_2) size_1k, and g_k by less than 10.001 v of U_k, the same two products of sizes.
 * DOUBLE_ERROR, 16 v, is a bound for both. The sums of T_k and of U_k are made from sums of sizes, and are too small by
 * at most 16 roundings.
 *
 * THE LINE, u = 2^-24. All as computed, let G = |g_z| + |g_j| + |g_l| and S = |C_z| + (|C_j| + |C_l|) / 2, or 2^-20 G
 * if that is more; and let S', G' be the same sums of the errors. F / S has the form of the edge functions of leaf.h,
 * and its coefficients have 1 rounding of u in place of 6. So, but for S' and G', it is off by less than
 *
 *     8.001 u R + (6.1 u X + 1.01 E) R rho,    rho = G / S.
 *
 * Edge functions have the bound 14 u R + (13 u X + 4 u R A + 2^-110) R rho. As |s| <= R / 2, S' adds R S' / S to the
 * error of F / S, and G' adds X R G' / S. To the bound, S' adds 14 / 6 of the former, and G' 13 / 6 of the latter:
 * twice as much as is needed.
 *
 * RANGE. With those of planes.h, C is 0 or within 2^-745 .. 2^313: nothing overflows or underflows.
 */
#include "trace/plane_order.h"

#include "bvh/unit.h"
#include "exact/rounding.h"
#include "hits/undecided.h"
#include "trace/planes.h"

#define DOUBLE_ERROR (16 * MLRT_UNIT_ROUNDOFF)

/* A line is used only if its error is at most this many times EDGE_ERROR, which is so up to S' = 378 u S. */
#define MOST_DOUBT 64

/* Sets the line of two planes. Returns 0 if it is too uncertain. */
static int set_line(const struct mlrt_turned_plane *first, const struct mlrt_turned_plane *second,
                    struct mlrt_pair_line *line)
{
    const double weight = mlrt_weigh(second->size);
    double moment[3], along[3], along_size = 0;
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        moment[k] = first->n * second->normal[k] - second->n * first->normal[k];
        along[k] = second->normal[i] * first->normal[j] - second->normal[j] * first->normal[i];
        along_size += first->size[k] * (second->size[i] + second->size[j]);
    }
    const double moment_size = first->n_size * weight + second->n_size * mlrt_weigh(first->size);
    const double length = mlrt_sum_of_magnitudes(along), least = 0x1p-20 * length, size = mlrt_weigh(moment);
    const double scale = 1 / (size > least ? size : least), doubt = DOUBLE_ERROR * (0x1p24 / 6) * scale;
    const double moment_doubt = 1 + doubt * moment_size, normal_scale = 1 / weight;
    mlrt_scale_edge(moment, along, scale, &line->constant, line->coefficient);
    line->error = (float)(EDGE_ERROR * moment_doubt);
    line->steepness = (float)((length * scale + doubt * along_size) * (1 + 0x1p-22));
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) line->normal[k] = (float)(second->normal[k] * normal_scale);
    return moment_doubt <= MOST_DOUBT;
}

static void turn_plane(const struct mlrt_tree *tree, const struct mlrt_waist *waist, uint32_t number,
                       struct mlrt_turned_plane *plane)
{
    struct mlrt_turned_corners corners;
    mlrt_turn_corners(tree, waist, number, &corners);
    mlrt_turn_plane(&corners, plane);
}

MLRT_NOINLINE void mlrt_set_pair_line(const struct mlrt_tree *tree, const struct mlrt_bundle_cache *cache,
                                      uint32_t first, uint32_t second, struct mlrt_worker *worker,
                                      struct mlrt_pair_line *line)
{
    struct mlrt_turned_plane plane_1, plane_2;
    line->waist_count = cache->waist_count;
    line->first = first;
    line->second = second;
    line->kind = MLRT_ONE_PLANE;
    if (mlrt_known_plane_of(worker, first) == mlrt_known_plane_of(worker, second)) return;
    line->kind = MLRT_NO_LINE;
    if (!tree->bvh.is_usual && (mlrt_is_odd(tree, first) || mlrt_is_odd(tree, second))) return;
    turn_plane(tree, &cache->waist, first, &plane_1);
    turn_plane(tree, &cache->waist, second, &plane_2);
    if (set_line(&plane_1, &plane_2, line)) {
        line->kind = MLRT_LINE;
    } else if (mlrt_have_one_plane(tree, first, second, worker)) {
        line->kind = MLRT_ONE_PLANE;
    }
}
