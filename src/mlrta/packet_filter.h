/* SPDX-License-Identifier: MIT */
/*
 * A packet against one triangle, by the filter of hits/triangle_filter.h. For rays of a common origin the terms come
 * from the triangle's set-up: its outline as seen from the apex, and the terms of its edge functions, which all packets
 * from that apex share. A worker keeps a small table of them for neighbouring packets. For other rays terms are
 * computed lane by lane.
 */
#ifndef MLRT_MLRTA_PACKET_FILTER_H
#define MLRT_MLRTA_PACKET_FILTER_H

#include <math.h>
#include <string.h>

#include "base/counters.h"
#include "hits/close_calls.h"
#include "hits/outcome.h"
#include "hits/triangle_filter.h"
#include "mlrta/outline.h"
#include "mlrta/ray_group.h"
#include "mlrta/setups.h"
#include "rays/extremes.h"
#include "scene/tree.h"
#include "simd/simd.h"

/* ---- set-ups ---- */

/* Empties the worker's table for packets from another apex. */
static void forget_setups(const float apex[3], struct mlrt_worker *worker)
{
    struct mlrt_setups *setups = worker->setups;
    for (uint32_t i = 0; i <= setups->mask; ++i) setups->entries[i].number = MLRT_NONE;
    memcpy(setups->apex, apex, sizeof setups->apex);
}

/* The table's entry for a triangle, with its outline. Its terms are only set if has_terms says so. */
MLRT_INLINE struct mlrt_triangle_setup *get_setup(const struct mlrt_tree *tree, uint32_t number,
                                                  const struct ray_group *group, struct mlrt_worker *worker)
{
    struct mlrt_triangle_setup *setup = &worker->setups->entries[number & worker->setups->mask];
    if (setup->number == number && setup->main_axis == group->axis_code) return setup;
    setup->has_terms = 0;
    setup->number = number;
    setup->main_axis = group->axis_code;
    set_triangle_outline(&tree->triangles[number], group->axis_code, worker->setups->apex, &setup->outline);
    return setup;
}

/* Weights of the components of a cross product in its size, by main axis (hits/triangle_filter.h). */
static const float axis_weights[3][3] = {{1, 0.5f, 0.5f}, {0.5f, 1, 0.5f}, {0.5f, 0.5f, 1}};

/*
 * Sets the terms of an entry (hits/triangle_filter.h): those of the three edges and of the normal at once. Not inlined:
 * 700 bytes less in SSE2, and 1 % more instructions for 2x2 packets.
 */
static MLRT_NOINLINE void set_up_terms(const struct mlrt_triangle *triangle, const float apex[3],
                                       struct mlrt_triangle_setup *setup)
{
    const float *weight = axis_weights[setup->main_axis & 3];
    f4 corner[3], sum[3], edge[3], reach[3], length[3], scale = f4_set1(1);
    f4_corners(triangle->v, corner);
    float vertex[3];
    for (int k = 0; k < 3; ++k) {
        const f4 to = f4_sub(corner[k], f4_set1(apex[k]));
        edge[k] = f4_sub(f4_next(corner[k]), corner[k]);    /* b - a, c - b, a - c, b - a */
        sum[k] = f4_join(f4_add(to, f4_next(to)), edge[k]); /* the normal is (a - c) x (b - a) */
        length[k] = f4_abs(edge[k]);
        reach[k] = f4_join(f4_max(f4_abs(sum[k]), length[k]), length[k]);
        vertex[k] = f4_last(to);
    }
    if (!MLRT_GUESS) {
        f4 size = f4_set1(SMALLEST_SIZE);
        for (int k = 0; k < 3; ++k) {
            const int p = (k + 1) % 3, q = (k + 2) % 3;
            const f4 products = f4_add(f4_mul(reach[p], length[q]), f4_mul(reach[q], length[p]));
            size = f4_add(size, f4_mul(products, f4_set1(weight[k])));
        }
        scale = f4_div(f4_set1(1), size);
    }
    f4 cross[3];
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        cross[k] = f4_sub(f4_mul(sum[p], edge[q]), f4_mul(sum[q], edge[p]));
        if (!MLRT_GUESS) cross[k] = f4_mul(cross[k], scale);
        f4_store(setup->cross[k], cross[k]);
    }
    setup->distance = vertex[0] * f4_last(cross[0]) + vertex[1] * f4_last(cross[1]) + vertex[2] * f4_last(cross[2]);
    float farthest = 0;
    for (int k = 0; k < 3; ++k) farthest = larger_of(fabsf(vertex[k]) * (1.5f - weight[k]), farthest);
    setup->distance_bound = farthest * (2 * DISTANCE_BOUND) + DISTANCE_FLOOR;
    setup->has_terms = 1;
    setup->in_plane = !MLRT_GUESS && MLRT_UNLIKELY(fabsf(setup->distance) <= setup->distance_bound) &&
                      mlrt_side_of_plane(triangle, apex) == 0;
}

/* ---- tests ---- */

/* The terms of a triangle for a vector of rays. Index 3 of cross is the normal. */
struct triangle_terms {
    vf cross[4][3]; /* (a + b) x (b - a) and so on relative to the origin, and n; each divided by its size */
    vf distance;    /* N' */
    vf distance_bound;
};

/* Computes the terms for rays of different origins. */
MLRT_INLINE void set_terms(const struct mlrt_triangle *triangle, const vf origin[3], uint32_t main_axis,
                           struct triangle_terms *terms)
{
    vf vertex[3][3], edge[3][3], sum[3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            const float from = triangle->v[i][k], to = triangle->v[(i + 1) % 3][k];
            vertex[i][k] = v_sub(v_set1(from), origin[k]);
            edge[i][k] = v_set1(to - from);
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) sum[k] = v_add(vertex[i][k], vertex[(i + 1) % 3][k]);
        scaled_cross_product(sum, edge[i], main_axis, terms->cross[i]);
    }
    /* n = (b - a) x (c - a) = (a - c) x (b - a) */
    scaled_cross_product(edge[2], edge[0], main_axis, terms->cross[3]);
    terms->distance = dot_product(vertex[0], terms->cross[3]);
    const vf other = v_max(v_abs(vertex[0][(main_axis + 1) % 3]), v_abs(vertex[0][(main_axis + 2) % 3]));
    const vf farthest = v_max(v_abs(vertex[0][main_axis]), v_mul(other, v_set1(2)));
    terms->distance_bound = v_add(v_mul(farthest, v_set1(DISTANCE_BOUND)), v_set1(DISTANCE_FLOOR));
}

/* Copies the terms for rays of a common origin from the triangle's set-up. */
MLRT_INLINE void set_apex_terms(const struct mlrt_triangle_setup *setup, struct triangle_terms *terms)
{
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) terms->cross[i][k] = v_set1(setup->cross[k][i]);
    }
    terms->distance = v_set1(setup->distance);
    terms->distance_bound = v_set1(setup->distance_bound);
}

/* The verdict on the rays `active` of the vector at lane v. `reach` is R of triangle_filter.h. */
MLRT_INLINE struct verdict filter_vector(const struct triangle_terms *terms, float reach,
                                         const struct mlrt_packet *packet, int v, vm active)
{
    const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                     v_load(packet->direction[2] + v)};
    const vf ab = dot_product(d, terms->cross[0]), bc = dot_product(d, terms->cross[1]),
             ca = dot_product(d, terms->cross[2]);
    struct float_test test;
    test.least = v_min(v_min(ab, bc), ca);
    test.greatest = v_max(v_max(ab, bc), ca);
    test.above = v_set1(EDGE_BOUND * reach);
    const vm candidates = may_be_inside(&test, active);
    if (!m_bits(candidates)) return (struct verdict){candidates, candidates, candidates, v_set1(0), v_set1(0)};
    test.determinant = dot_product(d, terms->cross[3]);
    test.plane_bound = v_set1(PLANE_BOUND * reach);
    test.distance = terms->distance;
    test.distance_bound = terms->distance_bound;
    return compare_distances(&test, candidates, v_load(packet->t_min + v), v_load(packet->nearest.lo + v),
                             v_load(packet->nearest.hi + v), 0);
}

/* The float part of test_triangle. */
MLRT_INLINE struct outcome filter_lanes(const struct mlrt_tree *tree, uint32_t number,
                                        const struct mlrt_triangle_setup *setup, const struct ray_group *group,
                                        uint32_t lanes, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    struct outcome outcome = {0, 0, 0};
    struct triangle_terms terms;
    uint32_t tested = 0;
    if (setup) set_apex_terms(setup, &terms);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        if (!(lanes >> v & ALL_LANES)) continue;
        const vm active = concerned_rays(packet, lanes, number, v);
        if (!m_bits(active)) continue;
        tested |= m_bits(active) << v;
        if (!setup) {
            const vf origin[3] = {v_load(packet->origin[0] + v), v_load(packet->origin[1] + v),
                                  v_load(packet->origin[2] + v)};
            set_terms(&tree->triangles[number], origin, group->axis_code & 3, &terms);
        }
        const struct verdict verdict = filter_vector(&terms, group->reach, packet, v, active);
        keep_verdict(&verdict, number, v, packet, &outcome);
    }
    COUNT(&worker->counters, lane_test_count, mlrt_count_bits(tested));
    (void)tested;
    return outcome;
}

/* The same without a set-up. Not inlined: callers whose rays have a common origin would save more registers. */
static MLRT_NOINLINE struct outcome filter_from_anywhere(const struct mlrt_tree *tree, uint32_t number,
                                                         const struct ray_group *group, uint32_t lanes,
                                                         struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    return filter_lanes(tree, number, NULL, group, lanes, packet, worker);
}

/*
 * Tests the rays `lanes` of `group` against triangle `number` and updates their nearest hits. `setup` is that of the
 * triangle if the rays have a common origin, else NULL. Returns the lanes whose nearest hit changed.
 */
static uint32_t test_triangle(const struct mlrt_job *job, uint32_t number, const struct mlrt_triangle_setup *setup,
                              const struct ray_group *group, uint32_t lanes, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    if (MLRT_UNLIKELY(packet->has.masks)) lanes = mlrt_seeing_lanes(job->tree, number, packet->mask, lanes);
    const struct outcome outcome = setup ? filter_lanes(job->tree, number, setup, group, lanes, packet, worker)
                                         : filter_from_anywhere(job->tree, number, group, lanes, packet, worker);
    if (MLRT_LIKELY(!outcome.undecided) || MLRT_GUESS) return outcome.nearer;
    return outcome.nearer |
           decide_lanes(job->tree, number, outcome.undecided, outcome.inside, packet, worker, COUNTERS(worker));
}

#endif
