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
#include "rays/extremes.h"
#include "simd/simd.h"

/* The vectors that hold the four lanes of a 2x2 packet: if VW > 4, one, which holds other lanes too. */
#define PACKET2_VECTORS (VW < 4 ? 4 / VW : 1)

struct masked_interval {
    vf lo[PACKET2_VECTORS];
    vf hi[PACKET2_VECTORS];
};

struct masked_cell {
    uint32_t node;
    uint32_t lanes;
    struct masked_interval part;
};

struct ray_axis {
    vf origin[PACKET2_VECTORS];
    vf small[PACKET2_VECTORS]; /* 1 / d, decreased in magnitude by RECIPROCAL_SLACK of itself, */
    vf large[PACKET2_VECTORS]; /* and increased */
};

struct lane_distances {
    vf lo;
    vf hi;
};

/* The distances within which the rays of vector i cross the plane x = c of this axis. */
MLRT_INLINE struct lane_distances lane_plane_distances(const struct ray_axis *axis, int i, float c)
{
    const vf x = v_sub(v_set1(c), axis->origin[i]);
    const vf a = v_mul(x, axis->small[i]), b = v_mul(x, axis->large[i]);
    return (struct lane_distances){v_min(a, b), v_max(a, b)};
}

/* The rays of the PACKET2_VECTORS from first_lane on, along axis k. */
MLRT_INLINE void set_ray_axis(const struct mlrt_packet *packet, int first_lane, int k, struct ray_axis *axis)
{
    for (int i = 0; i < PACKET2_VECTORS; ++i) {
        const int v = first_lane + i * VW;
        const vf reciprocal = v_div(v_set1(1), v_load(packet->direction[k] + v));
        axis->origin[i] = packet->has.apex ? v_set1(packet->apex[k]) : v_load(packet->origin[k] + v);
        axis->small[i] = v_mul(reciprocal, v_set1(1 - RECIPROCAL_SLACK));
        axis->large[i] = v_mul(reciprocal, v_set1(1 + RECIPROCAL_SLACK));
    }
}

/* Sets *part to the distances within which the rays are in a box. Returns the lanes that can be in it. */
MLRT_INLINE uint32_t enter_box(const struct mlrt_packet *packet, const struct ray_axis axis[3],
                               const uint32_t negative[3], const struct mlrt_box *box, int first_lane,
                               struct masked_interval *part)
{
    uint32_t inside = 0;
    for (int i = 0; i < PACKET2_VECTORS; ++i) {
        const int v = first_lane + i * VW;
        part->lo[i] = v_load(packet->t_min + v);
        part->hi[i] = v_load(packet->nearest.hi + v);
        for (int k = 0; k < 3; ++k) {
            const float near = negative[k] ? box->hi[k] : box->lo[k], far = negative[k] ? box->lo[k] : box->hi[k];
            part->lo[i] = v_max(lane_plane_distances(&axis[k], i, near).lo, part->lo[i]);
            part->hi[i] = v_min(lane_plane_distances(&axis[k], i, far).hi, part->hi[i]);
        }
        inside |= m_bits(v_le(part->lo[i], part->hi[i])) << v;
    }
    return inside;
}

/* Cuts *part down to the nearest hits. Returns the lanes that can still find a nearer one within it. */
MLRT_INLINE uint32_t cut_to_hits(const struct mlrt_packet *packet, int first_lane, struct masked_interval *part)
{
    uint32_t before = 0;
    for (int i = 0; i < PACKET2_VECTORS; ++i) {
        const int v = first_lane + i * VW;
        const vf nearest = v_load(packet->nearest.hi + v);
        before |= (~m_bits(v_gt(part->lo[i], nearest)) & ALL_LANES) << v;
        part->hi[i] = v_min(nearest, part->hi[i]);
    }
    return before;
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
        if (setup->number != number || setup->main_axis != group->axis_code || !setup->has_terms) {
            setup->number = number;
            setup->main_axis = group->axis_code;
            set_up_terms(&job->tree->triangles[number], packet->apex, setup);
        }
        if (setup->in_plane) return 0;
    }
    COUNT(&worker->counters, triangle_test_count, 1);
    return test_triangle(job, number, setup, group, group->lanes, packet, worker);
}

/* Traces rays whose directions have the same signs. Their lanes are in the PACKET2_VECTORS from first_lane on. */
MLRT_INLINE void traverse_masked_group(const struct mlrt_job *job, uint32_t lanes, int first_lane,
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
        group.axis[k].reach = negative[k] ? -range.lo[k] : range.hi[k];
        set_ray_axis(packet, first_lane, k, &axis[k]);
    }
    set_main_axis(&group);
    group.lanes &= enter_box(packet, axis, negative, &tree->bounds, first_lane, &part);
    if (!group.lanes) return;

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
            const uint32_t child = mlrt_node_child(here), first = child + negative[k], second = child + !negative[k];
            struct masked_interval far;
            struct masked_interval near;
            uint32_t near_lanes = 0, far_lanes = 0;
            for (int i = 0; i < PACKET2_VECTORS; ++i) {
                const int v = first_lane + i * VW;
                const struct lane_distances plane = lane_plane_distances(&axis[k], i, here->u.split);
                near_lanes |= (~m_bits(v_gt(part.lo[i], plane.hi)) & ALL_LANES) << v;
                far_lanes |= (~m_bits(v_lt(part.hi[i], plane.lo)) & ALL_LANES) << v;
                far.lo[i] = v_max(plane.lo, part.lo[i]);
                far.hi[i] = part.hi[i];
                near.lo[i] = part.lo[i];
                near.hi[i] = v_min(plane.hi, part.hi[i]);
            }
            near_lanes &= group.lanes;
            far_lanes &= group.lanes;
            if (!far_lanes) {
                node = first;
            } else if (!near_lanes) {
                node = second;
            } else {
                stack[pending_count++] = (struct masked_cell){second, far_lanes, far};
                part = near;
                group.lanes = near_lanes;
                node = first;
            }
            continue;
        }
        const uint32_t *entries = tree->kdtree.references + here->u.offset;
        const uint32_t count = mlrt_leaf_count(here);
        for (uint32_t i = 0; i < count && group.lanes; ++i) {
            const uint32_t changed = test_masked(job, entries[i], &group, packet, worker);
            if (!job->any) continue;
            alive &= ~changed;
            group.lanes &= alive;
        }
        do {
            if (pending_count == 0) return;
            --pending_count;
            node = stack[pending_count].node;
            part = stack[pending_count].part;
            group.lanes = stack[pending_count].lanes & alive & cut_to_hits(packet, first_lane, &part);
        } while (!group.lanes);
    }
}

/* Traces the active rays of a packet from the root, 2x2 at a time. */
MLRT_INLINE void traverse_masked(const struct mlrt_job *job, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    for (int square = 0; square < MLRT_PACKET_RAYS; square += 4) {
        const int first_lane = square - square % VW;
        for (uint32_t left = packet->active & (0xFu << square); left;) {
            const uint32_t same = same_sign_lanes(packet, left);
            traverse_masked_group(job, same, first_lane, packet, worker);
            left &= ~same;
        }
    }
}

#endif
