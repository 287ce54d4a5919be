/* SPDX-License-Identifier: MIT */
/*
 * A packet against one triangle, by the filter of hits/triangle_filter.h. For rays of a common origin the terms come
 * from the triangle's set-up; for others they are computed lane by lane.
 */
#ifndef MLRT_MLRTA_PACKET_FILTER_H
#define MLRT_MLRTA_PACKET_FILTER_H

#include "base/counters.h"
#include "hits/close_calls.h"
#include "hits/outcome.h"
#include "hits/triangle_filter.h"
#include "mlrta/ray_group.h"
#include "mlrta/setups.h"
#include "simd/simd.h"

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

/* The verdict on the rays `active` of the vector at lane v. `direction_size` is R of triangle_filter.h. */
MLRT_INLINE struct verdict filter_vector(const struct triangle_terms *terms, float direction_size,
                                         const struct mlrt_packet *packet, int v, vm active)
{
    const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                     v_load(packet->direction[2] + v)};
    const vf ab = dot_product(d, terms->cross[0]), bc = dot_product(d, terms->cross[1]),
             ca = dot_product(d, terms->cross[2]);
    struct float_test test;
    test.inner = inside_of_edges(ab, ca, bc);
    test.edge_bound = v_set1(EDGE_BOUND * direction_size);
    const vm candidates = may_be_inside(&test, active);
    if (!m_bits(candidates)) return (struct verdict){candidates, candidates, candidates, v_set1(0), v_set1(0)};
    test.determinant = dot_product(d, terms->cross[3]);
    test.plane_bound = v_set1(PLANE_BOUND * direction_size);
    test.distance = terms->distance;
    test.distance_bound = terms->distance_bound;
    return compare_distances(&test, candidates, v_load(packet->t_min + v), v_load(packet->nearest.lo + v),
                             v_load(packet->nearest.hi + v));
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
        const vm active = lanes_to_test(packet, lanes, number, v);
        if (!m_bits(active)) continue;
        tested |= m_bits(active) << v;
        if (!setup) {
            const vf origin[3] = {v_load(packet->origin[0] + v), v_load(packet->origin[1] + v),
                                  v_load(packet->origin[2] + v)};
            set_terms(&tree->triangles[number], origin, group->axis_code & 3, &terms);
        }
        const struct verdict verdict = filter_vector(&terms, group->direction_size, packet, v, active);
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
                              struct ray_group *group, uint32_t lanes, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    lanes = lanes_that_see(job, worker, packet, number, lanes);
    const struct outcome outcome = setup ? filter_lanes(job->tree, number, setup, group, lanes, packet, worker)
                                         : filter_from_anywhere(job->tree, number, group, lanes, packet, worker);
    if (MLRT_LIKELY(!outcome.undecided) || MLRT_GUESS) return outcome.nearer;
    group->effort_left -= (int)mlrt_count_bits(outcome.undecided);
    return outcome.nearer |
           decide_lanes(job->tree, number, outcome.undecided, outcome.inside, packet, worker, COUNTERS(worker));
}

#endif
