/* SPDX-License-Identifier: MIT */
/*
 * A bundle down the hierarchy of boxes, nearest boxes first. The sixteen boxes of a node are compared with the hull of
 * the whole bundle at once. Before a box is opened it is compared with the hulls of all sixteen packets at once, since
 * many of them may have nearer hits since. From a box on that only few rays meet, these go one by one (single_ray.h);
 * packets that are tested in vain too often go lane by lane (lane_by_lane.h).
 *
 * Based on: Reshetov et al. 2005 (one traversal for all rays of a tile); I. Wald, S. Boulos, P. Shirley, "Ray Tracing
 * Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007 (frusta against boxes).
 */
#ifndef MLRT_TRACE_TRAVERSE_BUNDLE_H
#define MLRT_TRACE_TRAVERSE_BUNDLE_H

#include <math.h>
#include <string.h>

#include "base/counters.h"
#include "simd/simd.h"
#include "simd/sixteen.h"
#include "trace/bundle.h"
#include "trace/cover.h"
#include "trace/hull_boxes.h"
#include "trace/hull_triangles.h"
#include "trace/lane_by_lane.h"
#include "trace/leaf.h"
#include "trace/packet_tests.h"
#include "trace/ray_hulls.h"
#include "trace/single_ray.h"
#include "trace/units.h"

/* A child on the stack. */
struct pending_box {
    float near;    /* least depth; negated if the farthest boxes are opened first */
    uint32_t slot; /* 16 * number of the node + place in it */
};

/* Prefetches the node, or the corners and numbers of the leaf, that is a child. */
MLRT_INLINE void prefetch_child(const struct mlrt_bvh *bvh, uint32_t child)
{
    const uint32_t quads = mlrt_bvh_quad_count(child), offset = mlrt_bvh_offset(child);
    const char *first = quads ? (const char *)(bvh->corners + 36 * (size_t)offset) : (const char *)&bvh->nodes[offset];
    const uint32_t size = quads ? 144 * quads : (uint32_t)sizeof *bvh->nodes;
    for (uint32_t i = 0; i < size; i += 64) mlrt_prefetch(first + i);
    if (quads) mlrt_prefetch(bvh->numbers + 4 * (size_t)offset);
}

/* Puts the children `met` on the stack, the nearest on top. Returns the new size of the stack. */
MLRT_INLINE uint32_t push_boxes(const struct mlrt_bvh *bvh, uint32_t node, uint32_t met,
                                const float near[MLRT_BVH_WIDTH], struct pending_box *stack, uint32_t count)
{
    const uint32_t base = count;
    for (; met; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        uint32_t at = count++;
        for (; at > base && stack[at - 1].near < near[place]; --at) stack[at] = stack[at - 1];
        stack[at] = (struct pending_box){near[place], node * MLRT_BVH_WIDTH + place};
        prefetch_child(bvh, bvh->nodes[node].child[place]);
    }
    return count;
}

/* Makes the hulls of packets again, from the extremes of bound_packet. */
static void finish_again(struct mlrt_bundle *bundle, uint32_t places)
{
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        if (!(places >> v & ALL_LANES)) continue;
        finish_depths(bundle, places, v);
        finish_hulls(bundle, v);
    }
}

/* Updates the bundle after new hits of a packet in the lanes `changed`. */
static MLRT_NOINLINE void update_bundle(struct mlrt_bundle *bundle, uint32_t place, uint32_t changed, int any)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    if (!any) {
        bundle->state.nearer |= 1u << place;
        return;
    }
    packet->active &= ~changed;
    if (!packet->active) {
        leave_bundle(bundle, place);
        return;
    }
    bound_packet(bundle, place);
    finish_again(bundle, 1u << place);
}

/*
 * Halves the active rays of a packet at the middle of the side along which they spread most at this depth. Returns one
 * half, or 0 if all are in one place.
 */
static uint32_t find_half(const struct mlrt_bundle *bundle, uint32_t place, float depth)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const uint32_t active = bundle->tile->packets[place].active;
    float width = 0;
    uint32_t below = 0;
    for (int i = 0; i < 2; ++i) {
        MLRT_ALIGNED(64) float at[MLRT_PACKET_RAYS];
        vf least = v_set1(INFINITY), greatest = v_set1(-INFINITY);
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            const vm lanes = m_from_bits(active >> v);
            const vf from = bundle->has.intercepts ? v_load(rays->term[MLRT_INTERCEPT_J + i] + v) : v_set1(0);
            const vf x = v_mul_add(v_load(rays->term[MLRT_SLOPE_J + i] + v), v_set1(depth), from);
            v_store(at + v, x);
            least = v_min(v_select(lanes, x, v_set1(INFINITY)), least);
            greatest = v_max(v_select(lanes, x, v_set1(-INFINITY)), greatest);
        }
        const float lo = v_hmin(least), hi = v_hmax(greatest);
        if (!(hi - lo > width)) continue;
        width = hi - lo;
        below = 0;
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            below |= m_bits(v_lt(v_load(at + v), v_set1(0.5f * (lo + hi)))) << v;
        }
    }
    return below & active;
}

/* Leaves one half of a packet in the bundle, and puts the other off. */
static void divide_packet(struct mlrt_bundle *bundle, uint32_t place)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const float first = larger_of(hulls->first[place], bundle->scene.core_first), last = hulls->last[place];
    const float end = last < bundle->scene.core_last ? last : bundle->scene.core_last;
    need_lanes(bundle, place);
    const uint32_t half = find_half(bundle, place, fabsf(end) > fabsf(first) ? end : first);
    if (!half) return;
    bundle->state.later[place] = (uint16_t)(packet->active & ~half);
    bundle->state.divided |= 1u << place;
    bundle->state.closed &= ~(1u << place);
    packet->active = half;
    bound_packet(bundle, place);
}

/* Takes a packet out of the bundle, ready to be traced lane by lane or one by one. */
static MLRT_NOINLINE void release_packet(struct mlrt_bundle *bundle, uint32_t place)
{
    leave_bundle(bundle, place);
    need_lanes(bundle, place);
    bundle->tile->packets[place].active |= bundle->state.later[place];
    bundle->state.later[place] = 0;
    set_packet_distances(&bundle->tile->rays[place], &bundle->tile->packets[place]);
}

/* Updates the hulls after new hits: rays look for nearer hits only. */
MLRT_INLINE void settle_bundle(struct mlrt_bundle *bundle)
{
    if (bundle->state.nearer & bundle->state.going)
        update_last_depths(bundle, bundle->state.nearer & bundle->state.going);
    bundle->state.nearer = 0;
    set_whole_last(bundle);
}

/* Traces lanes of a packet one by one through a child of a node. */
static MLRT_NOINLINE void trace_lanes_of_packet(const struct mlrt_job *job, struct mlrt_worker *worker,
                                                struct mlrt_bundle *bundle, uint32_t place, uint32_t lanes,
                                                uint32_t child)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    uint32_t changed = 0;
    const int is_first = !(bundle->state.has_reciprocals >> place & 1);
    if (is_first || !job->any) set_packet_distances(rays, packet); /* where any hit will do, all end at t_max */
    if (is_first) set_reciprocals(packet, &bundle->tile->reciprocals[place]);
    bundle->state.has_reciprocals |= 1u << place;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes), before = packet->nearest.triangle[lane];
        const struct ray_rows rows = rows_of_lane(packet, &bundle->tile->reciprocals[place], lane);
        trace_single(job, &rows, lane, child, packet, worker);
        if (packet->nearest.triangle[lane] == before) continue;
        set_lane_depths(packet, lane, rays);
        changed |= 1u << lane;
    }
    if (changed) update_bundle(bundle, place, changed, job->any);
}

/*
 * Do more than `most` rays of a packet probably meet a box? This is a guess by the sizes of the box and the packet, and
 * leaves room for an error of four times. A large box is worth a visit together, since neighbouring packets meet it
 * too.
 */
MLRT_INLINE int is_large_box(const struct mlrt_bundle *bundle, uint32_t place, const struct box_of_bundle *box,
                             uint32_t most)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const float depth = fabsf(box->from);
    float rays = MLRT_PACKET_RAYS, limit = 4 * (float)most;
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        rays *= box->hi[i] - box->lo[i];
        limit *= 2 * (hulls->filter.radius[i][place] * depth + hulls->filter.radius[MLRT_INTERCEPT_J + i][place]);
    }
    return rays > limit;
}

/*
 * If only few rays of the packets `met` meet a box, traces these one by one and returns 1: a visit together, and the
 * set-up of a leaf, pay only if many rays share them. Otherwise returns 0.
 */
static MLRT_NOINLINE int trace_few_of_bundle(const struct mlrt_job *job, struct mlrt_worker *worker,
                                             struct mlrt_bundle *bundle, const struct box_of_bundle *box,
                                             uint32_t child, uint32_t met)
{
    const uint32_t most = mlrt_bvh_quad_count(child) ? MLRT_FEW_LEAF_RAYS : MLRT_FEW_RAYS;
    uint32_t lanes[MLRT_BUNDLE_PACKETS], count = 0;
    if (!(fabsf(box->from) <= MLRT_SAFE_MAX && fabsf(box->to) <= MLRT_SAFE_MAX)) return 0; /* else 0 * inf is a NaN */
    if (is_large_box(bundle, mlrt_lowest_bit(met), box, most)) return 0;
    for (uint32_t left = met; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        need_lanes(bundle, place);
        lanes[place] = lanes_of_packet_met(bundle, place, box);
        count += mlrt_count_bits(lanes[place]);
        if (count > most) return 0;
        if (bundle->state.has_reciprocals >> place & 1 || !lanes[place]) continue;
        struct checked_lanes directions;
        check_lanes(bundle->tile->packets[place].direction, &directions);
        if (MLRT_UNLIKELY(bundle->tile->packets[place].active & ~directions.safe)) return 0;
    }
    for (; met; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        if (lanes[place]) trace_lanes_of_packet(job, worker, bundle, place, lanes[place], child);
    }
    settle_bundle(bundle);
    return 1;
}

/* Tests the rays of a packet against triangles of a leaf. Gives the packet up after too many tests in vain. */
static MLRT_NOINLINE void visit_by_packet(const struct mlrt_job *job, struct mlrt_worker *worker,
                                          struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                          uint32_t triangles, uint32_t place)
{
    need_lanes(bundle, place);
    const uint32_t changed = bundle->has.intercepts
                                 ? test_bundle_packet(job, worker, bundle, leaf, triangles, place, 1)
                                 : test_bundle_packet(job, worker, bundle, leaf, triangles, place, 0);
    const int is_alike = !bundle->has.intercepts || bundle->waist.is_beam;
    const uint32_t most = is_alike ? MLRT_MOST_WAIST_TESTS : job->any ? MLRT_MOST_ANY_TESTS : MLRT_MOST_TESTS;
    if (changed) update_bundle(bundle, place, changed, job->any);
    if (MLRT_UNLIKELY(bundle->state.tests[place] > most) && bundle->state.going >> place & 1) {
        release_packet(bundle, place);
        bundle->state.given_up |= 1u << place;
    }
}

/* Returns the triangles of a leaf that a packet is listed with, given the packets that each is listed with. */
MLRT_INLINE uint32_t triangles_of_packet(const uint32_t packets_of[MLRT_BVH_LEAF_LIMIT], uint32_t place)
{
    const vi bit = i_set1(1u << place);
    uint32_t triangles = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        triangles |= m_bits(i_eq(i_and(i_load(packets_of + v), bit), bit)) << v;
    }
    return triangles;
}

/*
 * Tests the packets `met` against a leaf. While a packet is closed, or that takes fewer tests, each triangle is tested
 * against all packets, a vector of them at a time (cover.h). Then each packet is tested against the other triangles.
 */
MLRT_INLINE void visit_leaf_of_bundle(const struct mlrt_job *job, struct mlrt_worker *worker,
                                      struct mlrt_bundle *bundle, uint32_t child, uint32_t met)
{
    uint32_t seen;
    const struct mlrt_bundle_leaf *leaf = find_bundle_leaf(job, bundle, child, worker, &seen);
    if (!seen) return;
    MLRT_ALIGNED(64) uint32_t packets_of[MLRT_BVH_LEAF_LIMIT] = {0};
    uint32_t listed = 0;
    for (; seen; seen &= seen - 1) {
        const uint32_t among = met & bundle->state.going;
        if (!among) break;
        const int is_cheaper = PACKET_VECTORS * mlrt_count_bits(seen) <= mlrt_count_bits(among);
        if (!(among & bundle->state.closed) && !is_cheaper) break;
        const uint32_t may = offer_to_packets(job, worker, bundle, leaf, mlrt_lowest_bit(seen), among);
        packets_of[mlrt_lowest_bit(seen)] = may;
        listed |= may;
    }
    for (met &= bundle->state.going & (seen ? met : listed); met; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        uint32_t triangles = listed >> place & 1 ? triangles_of_packet(packets_of, place) : 0;
        if (seen) triangles |= packet_triangles_met(bundle, leaf, place, seen);
        if (triangles) visit_by_packet(job, worker, bundle, leaf, triangles, place);
    }
    settle_bundle(bundle);
}

/* Traces a bundle through the hierarchy. */
static MLRT_NOINLINE void traverse_bundle(const struct mlrt_job *job, struct mlrt_worker *worker,
                                          struct mlrt_bundle *bundle)
{
    const int has_intercepts = bundle->has.intercepts;
    const struct mlrt_bvh *bvh = &job->tree->bvh;
    struct pending_box stack[MLRT_BVH_STACK_LIMIT];
    MLRT_ALIGNED(64) float near[MLRT_BVH_WIDTH];
    const int is_many = bundle->tile && mlrt_count_bits(bundle->state.going) >= MLRT_MANY_PACKETS &&
                        bundle->scene.unit == 1; /* else single rays would have to be scaled (units.h) */
    const uint32_t few = is_many ? MLRT_FEW_PACKETS : 0;
    uint32_t node = 0, count = 0;
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        const uint32_t boxes = bundle_children_met(bundle, &bvh->nodes[node], has_intercepts, near);
        for (int v = 0; bundle->far_first && v < MLRT_BVH_WIDTH; v += VW) {
            v_store(near + v, v_sub(v_set1(0), v_load(near + v)));
        }
        count = push_boxes(bvh, node, boxes, near, stack, count);
        for (;;) {
            if (count == 0) return;
            const struct pending_box *top = &stack[--count];
            if (!bundle->far_first && top->near > bundle->whole.last) continue;
            const struct mlrt_bvh_node *parent = &bvh->nodes[top->slot / MLRT_BVH_WIDTH];
            const uint32_t place = top->slot % MLRT_BVH_WIDTH, child = parent->child[place];
            struct box_of_bundle box;
            see_bundle_box(&bundle->waist, parent, place, &box);
            const uint32_t met = packets_met(bundle, &box, has_intercepts);
            if (!met) continue;
            if (mlrt_count_bits(met) <= few && !(met & bundle->state.closed) &&
                !(mlrt_bvh_quad_count(child) && has_bundle_leaf(bundle, child)) &&
                trace_few_of_bundle(job, worker, bundle, &box, child, met)) {
                continue;
            }
            if (!mlrt_bvh_quad_count(child)) {
                node = mlrt_bvh_offset(child);
                break;
            }
            COUNT(&worker->counters, cell_count, 1);
            visit_leaf_of_bundle(job, worker, bundle, child, met);
            if (MLRT_UNLIKELY(mlrt_count_bits(bundle->state.given_up) > MLRT_MOST_GIVEN_UP)) return;
        }
    }
}

#endif
