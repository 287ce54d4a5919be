/* SPDX-License-Identifier: MIT */
/*
 * One ray against the boxes of a node, a vector of them at a time, and the order in which its children are visited.
 *
 * BOXES. A ray is in a slab between t_near and t_far. Each is x r, with x = c - o for the plane at c, and r = 1 / d.
 * (The code has both factors with the opposite sign.) As computed, x and r have one rounding each; r is multiplied by
 * 1 -+ RECIPROCAL_SLACK (8 u), which is one rounding more. So before the product is rounded, t_near is surely too small
 * and t_far surely too large if they are positive. (A t_near that is not positive does not matter; a t_far that is
 * negative says rightly that the box is behind.) The rounding of the product is monotone, and t_min and the `hi` of the
 * nearest hit are floats: so where t_near <= t_far, t_near <= hi and t_min <= t_far are true, they remain true, even
 * with underflow. So a box is left out only if the ray surely passes it, or surely enters it behind `hi`.
 *
 * If d_k = 0, r is infinite. Then t_near is -inf and t_far inf if the origin is inside the slab; both are inf, or both
 * -inf, if it is outside; if it is on a plane of the slab, one is a NaN, which v_min and v_max drop because it is their
 * first operand. Distances beyond FLT_MAX are no hits (triangle_filter.h: t <= 2^121), so rays end there, and a box
 * with t_near = inf is left out. An empty slot is such a box, since its lo is inf and its hi -inf: so the slots in use
 * need not be counted.
 */
#ifndef MLRT_TRACE_SINGLE_RAY_BOXES_H
#define MLRT_TRACE_SINGLE_RAY_BOXES_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "rays/extremes.h"
#include "rays/lone_ray.h"
#include "rays/packet.h"
#include "simd/simd.h"
#include "trace/bundle.h"

/* Bytes from the start of a node to the lower, or upper, planes of its boxes along axis k. */
MLRT_INLINE uint32_t row_of_planes(uint32_t is_upper, uint32_t k)
{
    return (3 * is_upper + k) * (uint32_t)sizeof(float[MLRT_BVH_WIDTH]);
}

struct single_ray {
    vf origin[3];
    vf direction[3];
    vf near[3]; /* -1 / d, moved toward 0 */
    vf far[3];  /* -1 / d, moved away from 0 */
    vf t_min;
    size_t near_row[3];    /* per axis, the offset in a node of the planes that the ray crosses first */
    size_t far_row[3];     /* of those that it crosses last */
    float direction_limit; /* 4 m: see "Overflow" in triangle_test.h */
    uint32_t lane;
};

MLRT_INLINE void set_reciprocals(const struct mlrt_packet *packet, struct mlrt_reciprocals *reciprocals)
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            v_store(reciprocals->rounded[k] + v, v_div(v_set1(1), v_load(packet->direction[k] + v)));
        }
    }
}

/* Where the numbers of a ray lie: those of one vector are `step` floats apart. */
struct ray_rows {
    const float *origin;
    const float *direction;
    const float *reciprocal; /* 1 / d, rounded */
    size_t origin_step;
    size_t step;
};

/* Finds the numbers of a lane of a packet; without reciprocals if `reciprocals` is null. */
MLRT_INLINE struct ray_rows rows_of_lane(const struct mlrt_packet *packet, const struct mlrt_reciprocals *reciprocals,
                                         uint32_t lane)
{
    return (struct ray_rows){packet->has.apex ? packet->apex : packet->origin[0] + lane, packet->direction[0] + lane,
                             reciprocals ? reciprocals->rounded[0] + lane : NULL,
                             packet->has.apex ? 1 : MLRT_PACKET_RAYS, MLRT_PACKET_RAYS};
}

MLRT_INLINE struct ray_rows rows_of_lone_ray(const struct mlrt_lone_ray *ray)
{
    return (struct ray_rows){ray->origin, ray->direction, ray->reciprocal, 1, 1};
}

/* Likewise of the ray that a leaf is tested against: of a call of its own, or of a packet and without reciprocals. */
MLRT_INLINE struct ray_rows rows_of_tested_ray(const struct mlrt_packet *packet, uint32_t lane,
                                               const struct mlrt_worker *worker)
{
    return worker->lone ? rows_of_lone_ray(worker->lone) : rows_of_lane(packet, NULL, lane);
}

MLRT_INLINE void set_single_ray(const struct ray_rows *rows, const struct mlrt_packet *packet, uint32_t lane,
                                struct single_ray *ray)
{
    float greatest = 0;
    MLRT_UNROLL
    for (uint32_t k = 0; k < 3; ++k) {
        const float d = rows->direction[k * rows->step];
        const float r = rows->reciprocal[k * rows->step];
        const uint32_t lo = row_of_planes(0, k), hi = row_of_planes(1, k);
        ray->origin[k] = v_set1(rows->origin[k * rows->origin_step]);
        ray->direction[k] = v_set1(d);
        ray->near[k] = v_set1(r * (RECIPROCAL_SLACK - 1));
        ray->far[k] = v_set1(r * (-RECIPROCAL_SLACK - 1));
        ray->near_row[k] = d < 0 ? hi : lo;
        ray->far_row[k] = d < 0 ? lo : hi;
        greatest = larger_of(fabsf(d), greatest);
    }
    ray->direction_limit = 4 * greatest;
    ray->t_min = v_set1(packet->t_min[lane] + 0.0f); /* -0 becomes 0: see stack_entry */
    ray->lane = lane;
}

/* Where a ray ends, if not before: see "BOXES" above. */
MLRT_INLINE float finite_limit(float hi)
{
    return hi < FLT_MAX ? hi : FLT_MAX;
}

/*
 * Returns the boxes of a node that the ray can meet up to `limit`, one bit each. order[i] receives the distance at
 * which the ray enters box i, or with `any` the length that it spends in the box.
 */
MLRT_INLINE uint32_t meet_boxes(const struct single_ray *ray, const struct mlrt_bvh_node *node, float limit, int any,
                                float order[MLRT_BVH_WIDTH])
{
    enum { VECTORS = MLRT_BVH_WIDTH / VW };
    const char *planes = (const char *)node;
    vf first[VECTORS], last[VECTORS];
    uint32_t met = 0;
    MLRT_UNROLL
    for (int v = 0; v < VECTORS; ++v) first[v] = ray->t_min, last[v] = v_set1(limit);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const float *near = (const float *)(const void *)(planes + ray->near_row[k]);
        const float *far = (const float *)(const void *)(planes + ray->far_row[k]);
        MLRT_UNROLL
        for (int v = 0; v < VECTORS; ++v) {
            first[v] = v_max(v_mul(v_sub(ray->origin[k], v_load(near + v * VW)), ray->near[k]), first[v]);
            last[v] = v_min(v_mul(v_sub(ray->origin[k], v_load(far + v * VW)), ray->far[k]), last[v]);
        }
    }
    MLRT_UNROLL
    for (int v = 0; v < VECTORS; ++v) met |= m_bits(v_le(first[v], last[v])) << (v * VW);
    MLRT_UNROLL
    for (int v = 0; v < VECTORS; ++v) v_store(order + v * VW, any ? v_sub(last[v], first[v]) : first[v]);
    return met;
}

MLRT_INLINE uint32_t order_bits(float a)
{
    uint32_t bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}

/*
 * An entry of the stack has a child in its lower half, and in its upper half the bits of the distance at which the ray
 * enters it: floats that are not negative are in order as integers.
 */
MLRT_INLINE uint64_t stack_entry(float enter, uint32_t child)
{
    return (uint64_t)order_bits(enter) << 32 | child;
}

/*
 * The entry of a child; the lowest entry is visited first. For the closest hit that is the nearest child. For any hit
 * it is a leaf, which may end the search, or else the box that the ray spends the greatest length in. Nodes and leaves
 * visited per random ray (bindings/python/bench.py --only counts) if children are ordered by distance, with leaves
 * first, and with leaves first and then by length: erw6 2.54, 2.26, 2.25, conference 3.96, 3.63, 3.10, sponza 4.48,
 * 4.16, 3.40, clinic 3.59, 3.48, 3.15, dragon 4.49, 4.51, 4.14.
 */
MLRT_INLINE uint64_t child_entry(float order, uint32_t child, int any)
{
    if (!any) return stack_entry(order, child);
    return (uint64_t)(mlrt_bvh_quad_count(child) ? 0 : ~order_bits(order)) << 32 | child;
}

MLRT_INLINE void sort_entries(uint64_t *first, uint64_t *second)
{
    const uint64_t a = *first, b = *second;
    *first = a < b ? a : b;
    *second = a < b ? b : a;
}

/* The entry of the lowest child of `met`, which it leaves. */
MLRT_INLINE uint64_t take_child(const struct mlrt_bvh_node *node, uint32_t *met, const float order[MLRT_BVH_WIDTH],
                                int any)
{
    const uint32_t i = mlrt_lowest_bit(*met);
    *met &= *met - 1;
    return child_entry(order[i], node->child[i], any);
}

/*
 * Returns the child to visit first of those in `met`, which has at least one bit. The others go on the stack, sorted,
 * so that the next one to visit is on top. Up to three children are met mostly; then only their number takes branches.
 */
MLRT_INLINE uint32_t choose_child(const struct mlrt_bvh_node *node, uint32_t met, const float order[MLRT_BVH_WIDTH],
                                  int any, uint64_t *stack, uint32_t *count)
{
    if (!(met & (met - 1))) return node->child[mlrt_lowest_bit(met)];
    const uint32_t bottom = *count;
    uint64_t first = take_child(node, &met, order, any), second = take_child(node, &met, order, any);
    sort_entries(&first, &second);
    if (met) {
        uint64_t third = take_child(node, &met, order, any);
        sort_entries(&second, &third);
        sort_entries(&first, &second);
        stack[(*count)++] = third;
    }
    stack[(*count)++] = second;
    while (met) {
        uint64_t farther = take_child(node, &met, order, any);
        sort_entries(&first, &farther);
        uint32_t place = (*count)++;
        for (; place > bottom && stack[place - 1] < farther; --place) stack[place] = stack[place - 1];
        stack[place] = farther;
    }
    return (uint32_t)first;
}

#endif
