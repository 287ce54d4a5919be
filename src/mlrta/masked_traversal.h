/* SPDX-License-Identifier: MIT */
/*
 * Masked traversal: the rays of a 2x2 packet go down the tree together, each with its own interval of distances. They
 * visit a child if at least one of them does.
 *
 * The distance of each ray to a plane is computed and bounded as in interval_traversal.h.
 *
 * Based on: I. Wald, P. Slusallek, C. Benthin, M. Wagner, "Interactive Rendering with Coherent Ray Tracing",
 * Eurographics 2001.
 */
#ifndef MLRT_MLRTA_MASKED_TRAVERSAL_H
#define MLRT_MLRTA_MASKED_TRAVERSAL_H

#include "base/counters.h"
#include "mlrta/kdtree.h"
#include "mlrta/packet_filter.h"
#include "mlrta/ray_group.h"
#include "mlrta/setups.h"
#include "mlrta/triangle_setup.h"
#include "simd/simd.h"

/* Distances of the four rays of a 2x2 packet. */
struct masked_interval {
    f4 lo;
    f4 hi;
};

struct masked_cell {
    uint32_t node;
    uint32_t lanes;
    struct masked_interval part;
};

struct ray_axis {
    f4 origin;
    f4 small; /* 1 / d, decreased in magnitude by RECIPROCAL_SLACK of itself, */
    f4 large; /* and increased */
};

/* The distances within which the rays cross the plane x = c of this axis. */
MLRT_INLINE struct masked_interval lane_plane_distances(const struct ray_axis *axis, float c)
{
    const f4 x = f4_sub(f4_set1(c), axis->origin);
    const f4 a = f4_mul(x, axis->small), b = f4_mul(x, axis->large);
    return (struct masked_interval){f4_min(a, b), f4_max(a, b)};
}

/* The rays of the square from lane `first` on, along axis k. */
MLRT_INLINE struct ray_axis get_ray_axis(const struct mlrt_packet *packet, int first, int k)
{
    const f4 reciprocal = f4_div(f4_set1(1), f4_load(packet->direction[k] + first));
    return (struct ray_axis){packet->has.apex ? f4_set1(packet->apex[k]) : f4_load(packet->origin[k] + first),
                             f4_mul(reciprocal, f4_set1(1 - RECIPROCAL_SLACK)),
                             f4_mul(reciprocal, f4_set1(1 + RECIPROCAL_SLACK))};
}

/* The lanes of the square from lane `first` on where a > b is false. */
MLRT_INLINE uint32_t lanes_not_above(f4 a, f4 b, int first)
{
    return (~f4_above(a, b) & 15u) << first;
}

/* Sets *part to the distances within which the rays are in a box. Returns the lanes that can be in it. */
MLRT_INLINE uint32_t enter_box(const struct mlrt_packet *packet, const struct ray_axis axis[3],
                               const uint32_t negative[3], const struct mlrt_box *box, int first,
                               struct masked_interval *part)
{
    part->lo = f4_load(packet->t_min + first);
    part->hi = f4_load(packet->nearest.hi + first);
    for (int k = 0; k < 3; ++k) {
        const float near = negative[k] ? box->hi[k] : box->lo[k], far = negative[k] ? box->lo[k] : box->hi[k];
        part->lo = f4_max(lane_plane_distances(&axis[k], near).lo, part->lo);
        part->hi = f4_min(lane_plane_distances(&axis[k], far).hi, part->hi);
    }
    return lanes_not_above(part->lo, part->hi, first);
}

/*
 * Tests the rays of a group against a triangle. Returns the lanes whose nearest hit changed. The table of set-ups has
 * one entry, used for its terms only: this method tests no outlines.
 */
MLRT_INLINE uint32_t test_masked(const struct mlrt_job *job, uint32_t number, struct ray_group *group,
                                 struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    struct mlrt_triangle_setup *setup = packet->has.apex ? &worker->setups->entries[0] : NULL;
    if (setup) {
        if (setup->number != number || setup->axis_code != group->axis_code || !setup->has_terms) {
            setup->number = number;
            setup->axis_code = group->axis_code;
            set_up_terms(&job->tree->triangles[number], packet->apex, setup);
        }
        if (setup->in_plane) return 0;
    }
    COUNT(&worker->counters, triangle_test_count, 1);
    return test_triangle(job, number, setup, group, group->lanes, packet, worker);
}

/* Traces rays whose directions have the same signs, of the square from lane `first` on. */
MLRT_INLINE void traverse_masked_group(const struct mlrt_job *job, uint32_t lanes, int first,
                                       struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct mlrt_tree *tree = job->tree;
    struct ray_axis axis[3];
    struct ray_group group = {.lanes = lanes};
    uint32_t negative[3];
    struct lane_range range;
    struct masked_interval part;
    find_range(packet, lanes, &range);
    for (int k = 0; k < 3; ++k) {
        negative[k] = range.lo[k] < 0;
        group.axis[k].largest = negative[k] ? -range.lo[k] : range.hi[k];
        axis[k] = get_ray_axis(packet, first, k);
    }
    set_main_axis(&group);
    group.lanes &= enter_box(packet, axis, negative, &tree->bounds, first, &part);
    if (!group.lanes) return;

    group.effort_left = effort_of_group(group.lanes);
    struct masked_cell stack[MLRT_DEPTH_LIMIT];
    int pending_count = 0;
    uint32_t node = 0;
    uint32_t alive = group.lanes; /* rays still looking for a hit */
    COUNT(&worker->counters, packet_count, 1);
    for (;;) {
        const struct mlrt_node *here = &tree->kdtree.nodes[node];
        COUNT(&worker->counters, cell_count, 1);
        const uint32_t k = mlrt_node_axis(here);
        if (k != 3) {
            const uint32_t near = mlrt_node_child(here) + negative[k], far = mlrt_node_child(here) + !negative[k];
            const struct masked_interval plane = lane_plane_distances(&axis[k], here->u.split);
            const uint32_t near_lanes = lanes_not_above(part.lo, plane.hi, first) & group.lanes;
            const uint32_t far_lanes = lanes_not_above(plane.lo, part.hi, first) & group.lanes;
            if (!far_lanes) {
                node = near;
            } else if (!near_lanes) {
                node = far;
            } else {
                stack[pending_count++] = (struct masked_cell){far, far_lanes, {f4_max(plane.lo, part.lo), part.hi}};
                part.hi = f4_min(plane.hi, part.hi);
                group.lanes = near_lanes;
                node = near;
            }
            continue;
        }
        const uint32_t *entries = tree->kdtree.references + here->u.offset;
        const uint32_t count = mlrt_leaf_count(here);
        --group.effort_left;
        for (uint32_t i = 0; i < count && group.lanes && group.effort_left >= 0; ++i) {
            const uint32_t changed = test_masked(job, entries[i], &group, packet, worker);
            if (!job->any) continue;
            alive &= ~changed;
            group.lanes &= alive;
        }
        if (MLRT_UNLIKELY(group.effort_left < 0)) {
            packet->in_double |= alive;
            return;
        }
        const f4 nearest = f4_load(packet->nearest.hi + first);
        do {
            if (pending_count == 0) return;
            const struct masked_cell *next = &stack[--pending_count];
            node = next->node;
            part = (struct masked_interval){next->part.lo, f4_min(nearest, next->part.hi)};
            group.lanes = next->lanes & alive & lanes_not_above(part.lo, nearest, first);
        } while (!group.lanes);
    }
}

/* Traces the active rays of a packet from the root, 2x2 at a time. */
MLRT_INLINE void traverse_masked(const struct mlrt_job *job, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    for (int first = 0; first < MLRT_PACKET_RAYS; first += 4) {
        for (uint32_t left = packet->active & (0xFu << first); left;) {
            const uint32_t same = same_sign_lanes(packet, left);
            traverse_masked_group(job, same, first, packet, worker);
            left &= ~same;
        }
    }
}

#endif
