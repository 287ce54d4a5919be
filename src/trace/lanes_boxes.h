/* SPDX-License-Identifier: MIT */
/*
 * The lanes of a packet against the boxes of a node: either each box against all lanes at once, or each lane against
 * all boxes at once, whichever takes fewer steps. And the stack of boxes that lanes have yet to visit.
 *
 * The arithmetic and its bounds are those of single_ray_boxes.h. Before the lanes of a node are tested, its boxes are
 * compared with a hull of all lanes (lanes_hull.h), if that is narrow.
 */
#ifndef MLRT_TRACE_LANES_BOXES_H
#define MLRT_TRACE_LANES_BOXES_H

#include <float.h>
#include <math.h>

#include "base/counters.h"
#include "rays/extremes.h"
#include "rays/packet.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/lanes_hull.h"
#include "trace/single_ray_boxes.h"

/*
 * This many lanes, or fewer, are traced one by one. Zen 4, AVX-512: with 4, reflections have 0.98 of the speed, diffuse
 * rays 1.00; with 1, hemispheres 0.97 and diffuse rays 0.98.
 */
#define FEW_LANES 2

/* For this many lanes, or fewer, the hull is not worth its cost: the lanes are tested against all boxes. */
#define FEW_FOR_HULL 6

struct pending_lanes {
    float near; /* the least is on top: see push_lanes */
    uint32_t child;
    uint32_t lanes;
};

/* The rays of a packet as they are tested against boxes, as in struct single_ray. */
struct lanes_slabs {
    MLRT_ALIGNED(64) float near[3][MLRT_PACKET_RAYS]; /* -1 / d, moved toward 0 */
    MLRT_ALIGNED(64) float far[3][MLRT_PACKET_RAYS];  /* -1 / d, moved away from 0 */
    MLRT_ALIGNED(64) uint32_t near_row[3][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t far_row[3][MLRT_PACKET_RAYS];
};

/* The search of a packet: its rays as they are tested against boxes, and its stack. */
struct lanes_search {
    struct mlrt_reciprocals reciprocals;
    struct lanes_slabs slabs;
    struct lanes_hull hull;
    int one_origin;
    float origin[3];       /* of all rays, if one_origin */
    float direction_limit; /* 4 m: 4 times the greatest |d_k| of all lanes */
    uint32_t alive;        /* lanes that still need hits: where any hit will do, those without one */
    uint32_t count;
    struct pending_lanes stack[MLRT_BVH_STACK_LIMIT + 1];
};

/*
 * Sets what tests against boxes need along axis k. `least` receives the least component k of origins, of negated
 * origins, of directions, and of negated directions. If the packet has an apex, its row of origins is filled with it.
 */
MLRT_INLINE void set_lanes_along(struct mlrt_packet *packet, uint32_t lanes, int k, struct lanes_search *search,
                                 float least[4])
{
    struct extremes origins = NO_EXTREMES, directions = NO_EXTREMES;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf none = v_select(m_from_bits(lanes >> v), v_set1(0), v_set1(NAN)); /* extremes ignore NaNs */
        if (packet->has.apex) v_store(packet->origin[k] + v, v_set1(packet->apex[k]));
        const vf d = v_load(packet->direction[k] + v), r = v_div(v_set1(1), d);
        const vm down = v_lt(d, v_set1(0));
        v_store(search->reciprocals.rounded[k] + v, r);
        v_store(search->slabs.near[k] + v, v_mul(r, v_set1(RECIPROCAL_SLACK - 1)));
        v_store(search->slabs.far[k] + v, v_mul(r, v_set1(-RECIPROCAL_SLACK - 1)));
        const vi lower = i_set1(row_of_planes(0, k)), upper = i_set1(row_of_planes(1, k));
        i_store(search->slabs.near_row[k] + v, i_select(down, upper, lower));
        i_store(search->slabs.far_row[k] + v, i_select(down, lower, upper));
        add_to_extremes(v_add(v_load(packet->origin[k] + v), none), &origins);
        add_to_extremes(v_add(d, none), &directions);
    }
    f4_store(least, v_hmin4(origins.least, origins.negated, directions.least, directions.negated));
}

/* Begins the search of a packet. */
static MLRT_NOINLINE void begin_lanes(struct mlrt_packet *packet, uint32_t lanes, struct lanes_search *search)
{
    struct lanes_hull *hull = &search->hull;
    float greatest = 0;
    search->alive = lanes;
    search->count = 0;
    search->one_origin = 1;
    hull->least_t_min = lowest(packet->t_min, lanes);
    hull->farthest = finite_limit(highest(packet->nearest.hi, lanes));
    for (int k = 0; k < 3; ++k) {
        MLRT_ALIGNED(16) float least[4];
        set_lanes_along(packet, lanes, k, search, least);
        const float from = least[2], to = -least[3];
        search->origin[k] = least[0];
        search->one_origin &= least[0] == -least[1];
        greatest = larger_of(larger_of(-from, to), greatest);
        hull->lo[k] = least[0];
        hull->hi[k] = -least[1];
        set_hull_along(packet, lanes, k, from, to, hull);
    }
    search->direction_limit = 4 * greatest;
    hull->is_narrow = hull->farthest < FLT_MAX || hull->agree[0] + hull->agree[1] + hull->agree[2] >= 2;
}

/* Returns the boxes of a node that the hull of all lanes meets. Rays end at t = `farthest` at the latest. */
MLRT_INLINE uint32_t boxes_of_lanes(const struct lanes_hull *hull, const struct mlrt_bvh_node *node, float farthest)
{
    enum { VECTORS = MLRT_BVH_WIDTH / VW };
    uint32_t met = 0;
    struct boxes_in_hull boxes[VECTORS];
    MLRT_UNROLL
    for (int i = 0; i < VECTORS; ++i) begin_boxes(hull, farthest, &boxes[i]);
    for (int k = 0; k < 3; ++k) {
        MLRT_UNROLL
        for (int i = 0; i < VECTORS; ++i)
            cut_boxes(hull, k, v_load(node->lo[k] + i * VW), v_load(node->hi[k] + i * VW), &boxes[i]);
    }
    MLRT_UNROLL
    for (int i = 0; i < VECTORS; ++i) {
        const vm there = v_le(v_load(node->lo[0] + i * VW), v_load(node->hi[0] + i * VW));
        met |= m_bits(m_andnot(there, boxes_missed(&boxes[i]))) << i * VW;
    }
    return met;
}

/*
 * Returns those of `lanes` that may meet a box. Sets *near to the least t where one enters it; with `any`, to minus
 * their number. If `agree` is 1, the signs of all directions agree along each axis.
 */
MLRT_INLINE uint32_t lanes_in_box(const struct lanes_search *search, const struct mlrt_packet *packet,
                                  const struct mlrt_bvh_node *node, uint32_t place, uint32_t lanes, int any, int agree,
                                  float *near)
{
    enum { VECTORS = MLRT_PACKET_RAYS / VW };
    uint32_t met = 0;
    vf first[VECTORS], last[VECTORS], nearest = v_set1(INFINITY);
    MLRT_UNROLL
    for (int i = 0; i < VECTORS; ++i) {
        first[i] = v_load(packet->t_min + i * VW);
        last[i] = v_min(v_load(packet->nearest.hi + i * VW), v_set1(FLT_MAX));
    }
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int is_down = agree && search->hull.direction_hi[k] < 0;
        const vf lo = v_set1((is_down ? node->hi : node->lo)[k][place]);
        const vf hi = v_set1((is_down ? node->lo : node->hi)[k][place]);
        MLRT_UNROLL
        for (int i = 0; i < VECTORS; ++i) {
            const vf origin = v_load(packet->origin[k] + i * VW), near_factor = v_load(search->slabs.near[k] + i * VW);
            const vm down = v_gt(near_factor, v_set1(0)); /* d_k < 0 */
            const vf x = v_sub(origin, agree ? lo : v_select(down, hi, lo));
            const vf y = v_sub(origin, agree ? hi : v_select(down, lo, hi));
            first[i] = v_max(v_mul(x, near_factor), first[i]);
            last[i] = v_min(v_mul(y, v_load(search->slabs.far[k] + i * VW)), last[i]);
        }
    }
    MLRT_UNROLL
    for (int i = 0; i < VECTORS; ++i) {
        const vm hit = m_and(m_from_bits(lanes >> i * VW), v_le(first[i], last[i]));
        if (!any) nearest = v_min(v_select(hit, first[i], v_set1(INFINITY)), nearest);
        met |= m_bits(hit) << i * VW;
    }
    *near = any ? -(float)mlrt_count_bits(met) : v_hmin(nearest);
    return met;
}

/* Of each box of a node that lanes meet: these lanes, and what orders it on the stack, the least on top. */
struct boxes_met {
    MLRT_ALIGNED(64) float near[MLRT_BVH_WIDTH];
    MLRT_ALIGNED(64) uint32_t lanes_of[MLRT_BVH_WIDTH];
};

/* See meet_by_boxes; `agree` is as in lanes_in_box. */
MLRT_INLINE uint32_t meet_each_box(const struct mlrt_packet *packet, const struct mlrt_bvh_node *node, uint32_t boxes,
                                   uint32_t lanes, int any, int agree, const struct lanes_search *search,
                                   struct boxes_met *of)
{
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) v_store(of->near + v, v_set1(0));
    for (; boxes; boxes &= boxes - 1) {
        const uint32_t place = mlrt_lowest_bit(boxes);
        of->lanes_of[place] = lanes_in_box(search, packet, node, place, lanes, any, agree, &of->near[place]);
        met |= (uint32_t)(of->lanes_of[place] != 0) << place;
    }
    return met;
}

/* Tests each of `boxes` against all lanes at once. Returns the boxes that a lane may meet. */
MLRT_INLINE uint32_t meet_by_boxes(const struct mlrt_packet *packet, const struct mlrt_bvh_node *node, uint32_t boxes,
                                   uint32_t lanes, int any, const struct lanes_search *search, struct boxes_met *of)
{
    const int *agree = search->hull.agree;
    return agree[0] & agree[1] & agree[2] ? meet_each_box(packet, node, boxes, lanes, any, 1, search, of)
                                          : meet_each_box(packet, node, boxes, lanes, any, 0, search, of);
}

/*
 * Of the boxes of a node, two vectors are tested together, since they share what is loaded of a lane. Sixteen lanes
 * need one vector.
 */
#define VECTORS_TOGETHER (VW < MLRT_BVH_WIDTH ? 2 : 1)
#define BOXES_TOGETHER   (VECTORS_TOGETHER * VW)

/*
 * Tests each lane against the BOXES_TOGETHER boxes from `begin` on, and sets near and lanes_of of each. Returns the
 * boxes that a lane may meet.
 */
MLRT_INLINE uint32_t test_boxes_by_lanes(const struct mlrt_packet *packet, const struct mlrt_bvh_node *node, int begin,
                                         uint32_t lanes, int any, const struct lanes_search *search,
                                         struct boxes_met *of_boxes)
{
    const char *planes = (const char *)(node->lo[0] + begin);
    vf nearest[VECTORS_TOGETHER];
    vi of[VECTORS_TOGETHER];
    uint32_t met = 0;
    MLRT_UNROLL
    for (int i = 0; i < VECTORS_TOGETHER; ++i) {
        nearest[i] = v_set1(INFINITY);
        of[i] = i_set1(0);
    }
    for (uint32_t left = lanes; left; left &= left - 1) {
        const uint32_t lane = mlrt_lowest_bit(left);
        vf first[VECTORS_TOGETHER], last[VECTORS_TOGETHER];
        MLRT_UNROLL
        for (int i = 0; i < VECTORS_TOGETHER; ++i) {
            first[i] = v_set1(packet->t_min[lane]);
            last[i] = v_set1(finite_limit(packet->nearest.hi[lane]));
        }
        MLRT_UNROLL
        for (uint32_t k = 0; k < 3; ++k) {
            const float *near = (const float *)(const void *)(planes + search->slabs.near_row[k][lane]);
            const float *far = (const float *)(const void *)(planes + search->slabs.far_row[k][lane]);
            const vf origin = v_set1(packet->origin[k][lane]);
            MLRT_UNROLL
            for (int i = 0; i < VECTORS_TOGETHER; ++i) {
                const vf x = v_sub(origin, v_load(near + i * VW)), y = v_sub(origin, v_load(far + i * VW));
                first[i] = v_max(v_mul(x, v_set1(search->slabs.near[k][lane])), first[i]);
                last[i] = v_min(v_mul(y, v_set1(search->slabs.far[k][lane])), last[i]);
            }
        }
        MLRT_UNROLL
        for (int i = 0; i < VECTORS_TOGETHER; ++i) {
            const vm hit = v_le(first[i], last[i]);
            nearest[i] = v_min(v_select(hit, any ? v_sub(first[i], last[i]) : first[i], nearest[i]), nearest[i]);
            of[i] = i_select(hit, i_sub(of[i], i_set1(0u - (1u << lane))), of[i]);
        }
    }
    MLRT_UNROLL
    for (int i = 0; i < VECTORS_TOGETHER; ++i) {
        const int v = begin + i * VW;
        v_store(of_boxes->near + v, nearest[i]);
        i_store(of_boxes->lanes_of + v, of[i]);
        met |= (~m_bits(i_eq(of[i], i_set1(0))) & ALL_LANES) << v;
    }
    return met;
}

/* Tests each lane against all boxes at once. Returns the boxes that a lane may meet. */
MLRT_INLINE uint32_t meet_by_lanes(const struct mlrt_packet *packet, const struct mlrt_bvh_node *node, uint32_t lanes,
                                   int any, const struct lanes_search *search, struct boxes_met *of)
{
    uint32_t met = 0;
    for (int begin = 0; begin < MLRT_BVH_WIDTH; begin += BOXES_TOGETHER) {
        met |= test_boxes_by_lanes(packet, node, begin, lanes, any, search, of);
    }
    return met;
}

MLRT_INLINE struct pending_lanes child_met(const struct mlrt_bvh_node *node, const struct boxes_met *of, uint32_t place)
{
    return (struct pending_lanes){of->near[place], node->child[place], of->lanes_of[place]};
}

/* Puts two children on the stack, the nearer on top. With `any`, leaves count as nearest. */
MLRT_INLINE void push_two(const struct mlrt_bvh_node *node, const struct boxes_met *of, uint32_t met, int any,
                          struct pending_lanes *top)
{
    const uint32_t a = mlrt_lowest_bit(met), b = mlrt_lowest_bit(met & (met - 1));
    const float near_a = any && mlrt_bvh_quad_count(node->child[a]) ? -INFINITY : of->near[a];
    const float near_b = any && mlrt_bvh_quad_count(node->child[b]) ? -INFINITY : of->near[b];
    const int is_a_nearer = near_a < near_b;
    top[is_a_nearer] = child_met(node, of, a);
    top[!is_a_nearer] = child_met(node, of, b);
}

/*
 * Puts children on the stack in order. The place of each is the number of those that are farther, or the next one that
 * is free: no branch depends on distances, which are no NaNs. With `any`, leaves count as nearest.
 */
MLRT_INLINE void push_several(const struct mlrt_bvh_node *node, const struct boxes_met *of, uint32_t met, int any,
                              struct pending_lanes *top)
{
    uint32_t leaves = 0, taken = 0;
    for (uint32_t left = any ? met : 0; left; left &= left - 1) {
        leaves |= mlrt_bvh_quad_count(node->child[mlrt_lowest_bit(left)]) ? left & (0u - left) : 0;
    }
    for (uint32_t left = met; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        uint32_t farther = 0;
        for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) {
            farther |= m_bits(v_gt(v_load(of->near + v), v_set1(of->near[place]))) << v;
        }
        const uint32_t below = leaves >> place & 1 ? met & ~leaves : met & ~leaves & farther;
        const uint32_t at = mlrt_lowest_bit(~taken & (~0u << mlrt_count_bits(below)));
        taken |= 1u << at;
        top[at] = child_met(node, of, place);
    }
}

/*
 * Puts the children of a node that lanes may meet on the stack, the nearest on top. Where any hit will do, leaves are
 * on top, then the boxes that most lanes meet (meet_by_boxes), or in which a lane is longest (meet_by_lanes).
 */
MLRT_INLINE void push_lanes(const struct mlrt_packet *packet, const struct mlrt_bvh_node *node, uint32_t lanes, int any,
                            struct lanes_search *search)
{
    const uint32_t lane_count = mlrt_count_bits(lanes);
    struct pending_lanes *top = &search->stack[search->count];
    struct boxes_met of;
    uint32_t boxes = 0xFFFF;
    if (lane_count > FEW_FOR_HULL && search->hull.is_narrow) {
        boxes = boxes_of_lanes(&search->hull, node, last_end(&search->hull, packet, lanes, any));
    }
    const uint32_t met = lane_count <= mlrt_count_bits(boxes)
                             ? meet_by_lanes(packet, node, lanes, any, search, &of)
                             : meet_by_boxes(packet, node, boxes, lanes, any, search, &of);
    const uint32_t met_count = mlrt_count_bits(met);
    search->count += met_count;
    if (met_count > 2) {
        push_several(node, &of, met, any, top);
    } else if (met_count == 2) {
        push_two(node, &of, met, any, top);
    } else if (met) {
        *top = child_met(node, &of, mlrt_lowest_bit(met));
    }
}

#endif
