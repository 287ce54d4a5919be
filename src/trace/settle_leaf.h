/* SPDX-License-Identifier: MIT */
/*
 * Decides what the tests of a packet against a leaf leave undecided (packet_tests.h): by the line of two planes where
 * the nearest hit is asked for, else in double where rays begin or end; and at last as close calls.
 */
#ifndef MLRT_TRACE_SETTLE_LEAF_H
#define MLRT_TRACE_SETTLE_LEAF_H

#include "base/counters.h"
#include "hits/close_calls.h"
#include "hits/triangle_filter.h"
#include "hits/undecided.h"
#include "job/stop.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/leaf.h"
#include "trace/nearest_hits.h"
#include "trace/plane_order.h"
#include "trace/plane_sides.h"

/* Returns F of a vector of rays (plane_order.c), and sets *bound to its error bound. */
MLRT_INLINE vf find_line_values(const struct mlrt_pair_line *line, const struct mlrt_bundle *bundle, uint32_t place,
                                int v, vf *bound)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const float size = bundle->hulls.filter.direction_size[place];
    float error = line->error;
    vf f = v_set1(line->constant);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) f = v_mul_add(v_set1(line->coefficient[i]), v_load(rays->term[i] + v), f);
    if (bundle->has.intercepts) {
        error += line->steepness * bundle->hulls.filter.blur[place];
        MLRT_UNROLL
        for (int i = 2; i < MLRT_RAY_TERMS; ++i) {
            f = v_mul_add(v_set1(line->coefficient[i]), v_load(rays->term[i] + v), f);
        }
    }
    *bound = v_set1(error * size * (1 + SLOPE_SLACK));
    return f;
}

/*
 * Finds the rays for which F D_2 is surely above 0, and those for which it is surely below. The sign of D_1 then tells
 * that of t_1 - t_2.
 */
MLRT_INLINE void find_line_sides(const struct mlrt_pair_line *line, const struct mlrt_bundle *bundle, uint32_t place,
                                 int v, vm *above, vm *below)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    vf bound, d = v_set1(line->normal[0]);
    const vf f = find_line_values(line, bundle, place, v, &bound);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) d = v_mul_add(v_set1(line->normal[1 + i]), v_load(rays->term[i] + v), d);
    const vf signed_f = v_flip(f, d);
    const vm sure = v_gt(v_abs(d), v_set1(PLANE_BOUND * bundle->hulls.filter.direction_size[place]));
    *above = m_and(sure, v_gt(signed_f, bound));
    *below = m_and(sure, v_lt(signed_f, v_sub(v_set1(0), bound)));
}

/*
 * Decides lanes of a vector where distances do not tell whether a triangle or the nearest hit so far comes first, by
 * the line of their planes (L15), as settle_covers in cover.h does. Returns the lanes that remain undecided.
 */
MLRT_INLINE uint32_t settle_lanes(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                                  uint32_t place, uint32_t number, uint32_t lanes, vm inside,
                                  const struct plane_of_rays *plane, int v, struct nearest_hits *hits)
{
    MLRT_ALIGNED(64) uint32_t nearest_of[VW];
    const vi found = hits->triangle;
    uint32_t left = lanes;
    i_store(nearest_of, found);
    while (lanes) {
        const uint32_t nearest = nearest_of[mlrt_lowest_bit(lanes)];
        const uint32_t same = lanes & m_bits(i_eq(found, i_set1(nearest)));
        lanes &= ~same;
        if (nearest == MLRT_NONE) continue;
        const struct mlrt_pair_line *line = mlrt_find_pair_line(job->tree, number, nearest, worker, bundle->cache);
        if (line->kind == MLRT_ONE_PLANE) { /* as in settle_tie, hits/undecided.c */
            const uint32_t tied = number > nearest ? same : same & m_bits(inside);
            if (number < nearest) hits->triangle = i_select(m_from_bits(tied), i_set1(number), hits->triangle);
            left &= ~tied;
        } else if (line->kind == MLRT_LINE) {
            vm above, below;
            find_line_sides(line, bundle, place, v, &above, &below);
            const vm these = m_and(m_from_bits(same), plane->certain), backward = m_and(these, plane->backward);
            const vm forward = m_andnot(these, backward);
            const vm farther = m_or(m_and(above, forward), m_and(below, backward));
            const vm before = m_or(m_and(below, forward), m_and(above, backward));
            const vm nearer = m_and(before, m_and(inside, plane->begun));
            keep_plane(plane, number, nearer, hits);
            left &= ~m_bits(m_or(farther, nearer));
        }
    }
    return left;
}

/*
 * Decides lanes of a vector in double or exactly (close_calls.h, undecided.h). Returns the lanes whose nearest hit is
 * not the one that the packet had before.
 */
static MLRT_NOINLINE uint32_t decide_bundle_lanes(const struct mlrt_job *job, struct mlrt_worker *worker,
                                                  struct mlrt_bundle *bundle, uint32_t place, uint32_t number,
                                                  uint32_t lanes, vm inside, int v, struct nearest_hits *nearest)
{
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const uint32_t changed = store_nearest_hits(nearest, v, rays, packet);
    if (job->any) { /* undecided lanes have no hit: their rays end at t_max */
        for (int i = 0; i < MLRT_PACKET_RAYS; i += VW) {
            v_store(packet->nearest.lo + i, v_load(packet->t_max + i));
            v_store(packet->nearest.hi + i, v_load(packet->t_max + i));
        }
    } else {
        set_packet_distances(rays, packet);
    }
    const uint32_t hit =
        decide_lanes(job->tree, number, lanes << v, m_bits(inside) << v, packet, worker, COUNTERS(worker));
    for (uint32_t those = job->any ? 0 : hit; those; those &= those - 1) {
        set_lane_depths(packet, mlrt_lowest_bit(those), rays);
    }
    load_nearest_hits(rays, packet, v, nearest);
    return changed | hit;
}

/*
 * Where any hit will do: decides lanes whose rays may begin, or end, at the plane of a triangle, by the sign of N - t D
 * there (plane_sides.h). A call decides only one of both ends and one sign of D, those of the first lane. Returns
 * the lanes that remain undecided.
 */
static MLRT_NOINLINE uint32_t settle_ends(const struct mlrt_tree *tree, const struct mlrt_bundle *bundle,
                                          const struct mlrt_bundle_leaf *leaf, uint32_t triangle, uint32_t place,
                                          uint32_t lanes, vm inside, const struct plane_of_rays *of, int v,
                                          struct nearest_hits *hits)
{
    const struct mlrt_packet *packet = &bundle->tile->packets[place];
    const uint32_t begun = m_bits(of->begun), backward = m_bits(of->backward);
    uint32_t those = lanes & m_bits(of->certain);
    if (!those) return lanes;
    const uint32_t first = mlrt_lowest_bit(those);
    const int at_end = begun >> first & 1, is_backward = backward >> first & 1;
    those &= (at_end ? begun : ~begun) & (is_backward ? backward : ~backward);
    struct mlrt_plane plane;
    const struct mlrt_triangle corners = triangle_of_leaf(tree, leaf, triangle);
    mlrt_set_plane(&corners, &plane);
    const float *t = at_end ? packet->t_max : packet->has.limits ? packet->t_min : NULL;
    struct measured_lanes n;
    measure_n(&plane, packet, 0, &n);
    const struct sides_of_plane sides =
        find_sides_of_plane(&plane, packet, t, is_backward ? -bundle->waist.sign : bundle->waist.sign, &n);
    vm farther, nearer;
    compare_planes(of, hits, &farther, &nearer);
    const uint32_t missed = (at_end ? sides.before : sides.behind) >> v & those;
    const uint32_t within = at_end ? sides.behind >> v : sides.before >> v & m_bits(nearer);
    const uint32_t hit = those & within & m_bits(inside);
    hits->triangle = i_select(m_from_bits(hit), i_set1(leaf->numbers[triangle]), hits->triangle);
    return lanes & ~(missed | hit);
}

/* A triangle of a leaf, and the lanes of a vector that its test left undecided. */
struct close_triangle_of_leaf {
    struct plane_of_rays plane;
    vm inside;
    uint32_t lanes; /* that are undecided */
    uint32_t triangle;
};

/*
 * Decides what the tests of a vector of rays against the triangles of a leaf left undecided. All triangles have been
 * tested before, so where any hit will do, lanes that hit one of them need no decision. Returns the lanes whose nearest
 * hit is not the one that the packet had before.
 */
static MLRT_NOINLINE uint32_t settle_leaf(const struct mlrt_job *job, struct mlrt_worker *worker,
                                          struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                          uint32_t place, struct close_triangle_of_leaf *close, uint32_t count, int v,
                                          struct nearest_hits *nearest)
{
    uint32_t decided = 0;
    for (uint32_t i = 0; i < count; ++i) {
        struct plane_of_rays *plane = &close[i].plane;
        const uint32_t number = leaf->numbers[close[i].triangle];
        uint32_t left = close[i].lanes;
        if (mlrt_is_stopped_in_step(worker)) return decided;
        if (leaf->state.flipped >> close[i].triangle & 1) {
            plane->backward = m_andnot(m_from_bits(ALL_LANES), plane->backward);
        }
        if (job->any) {
            left &= m_bits(i_eq(nearest->triangle, i_set1(MLRT_NONE)));
            if (left)
                left = settle_ends(job->tree, bundle, leaf, close[i].triangle, place, left, close[i].inside, plane, v,
                                   nearest);
        } else {
            left = settle_lanes(job, worker, bundle, place, number, left, close[i].inside, plane, v, nearest);
        }
        if (left) {
            decided |= decide_bundle_lanes(job, worker, bundle, place, number, left, close[i].inside, v, nearest);
        }
    }
    return decided;
}

#endif
