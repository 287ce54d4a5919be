/* SPDX-License-Identifier: MIT */
/*
 * One ray at a time down the hierarchy of boxes, for rays that have nothing in common. A vector holds the boxes of a
 * node, or the triangles of a leaf. Of the children that the ray meets, the nearest is visited first (with a query for
 * any hit: the one that is most likely to have a hit). The others wait on a stack, and are dropped if they begin behind
 * the nearest hit so far.
 *
 * Based on: I. Wald et al., "Getting Rid of Packets", 2008 (one ray, wide nodes).
 */
#ifndef MLRT_TRACE_SINGLE_RAY_H
#define MLRT_TRACE_SINGLE_RAY_H

#include <stddef.h>

#include "base/counters.h"
#include "simd/simd.h"
#include "trace/single_ray_boxes.h"
#include "trace/single_ray_leaf.h"

/* Node `child`. Its byte offset is child * 56: cheaper than its number times the 448 bytes of a node. */
MLRT_INLINE const struct mlrt_bvh_node *node_of(const struct mlrt_bvh_node *nodes, uint32_t child)
{
    return (const struct mlrt_bvh_node *)((const char *)nodes + child * (sizeof *nodes / 8));
}

/*
 * Traces one lane of a packet through `child` and the tree below it. `any` is that of the job. Returns where the
 * corners of its nearest hit lie; if nothing nearer was found, `corner` is NULL.
 */
MLRT_INLINE struct mlrt_corners trace_lane(const struct mlrt_job *job, int any, const struct ray_rows *rows,
                                           uint32_t lane, uint32_t child, struct mlrt_packet *packet,
                                           struct mlrt_worker *worker)
{
    const struct mlrt_bvh_node *nodes = job->tree->bvh.nodes;
    MLRT_ALIGNED(64) float order[MLRT_BVH_WIDTH];
    uint64_t stack[MLRT_BVH_STACK_LIMIT];
    struct corner_rows nearest = {NULL, 0};
    uint32_t count = 0;
    struct single_ray ray;
    set_single_ray(rows, packet, lane, &ray);
    float limit = finite_limit(packet->nearest.hi[lane]);
    COUNT(&worker->counters, packet_count, 1);
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        if (mlrt_bvh_quad_count(child) == 0) {
            const struct mlrt_bvh_node *node = node_of(nodes, child);
            const uint32_t met = meet_boxes(&ray, node, limit, any, order);
            if (met) {
                child = choose_child(node, met, order, any, stack, &count);
                continue;
            }
        } else {
            if (test_leaf(job, any, &ray, child, &nearest, packet, worker)) break;
            limit = finite_limit(packet->nearest.hi[lane]);
        }
        do {
            if (count == 0) return (struct mlrt_corners){nearest.corner, (uint32_t)nearest.row, 1};
            --count;
        } while (!any && stack[count] > stack_entry(limit, 0xFFFFFFFFu));
        child = (uint32_t)stack[count];
    }
    return (struct mlrt_corners){nearest.corner, (uint32_t)nearest.row, 1};
}

/* The same for lanes of packets, whose rays are many: compiled once for all queries. */
static MLRT_NOINLINE void trace_single(const struct mlrt_job *job, const struct ray_rows *rows, uint32_t lane,
                                       uint32_t child, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    (void)trace_lane(job, job->any, rows, lane, child, packet, worker);
}

#endif
