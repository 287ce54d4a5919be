/* SPDX-License-Identifier: MIT */
/*
 * Traces a packet lane by lane: each lane is tested against each box (lanes_boxes.h) and each triangle (lanes_leaf.h).
 * This is for packets whose rays have too little in common for a hull. From a box on that only few lanes meet, these
 * are traced one by one (single_ray.h).
 *
 * Based on: I. Wald, C. Benthin, P. Slusallek, "Interactive Rendering with Coherent Ray Tracing", 2001 (packets against
 * one box); C. Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel
 * MIC Architecture", 2012 (the way from packets to single rays).
 */
#ifndef MLRT_TRACE_LANE_BY_LANE_H
#define MLRT_TRACE_LANE_BY_LANE_H

#include "base/counters.h"
#include "hits/trace_in_double.h"
#include "rays/check_packet.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/lanes_boxes.h"
#include "trace/lanes_leaf.h"
#include "trace/single_ray.h"
#include "trace/units.h"

/* Traces lanes one by one through a child of a node. */
static MLRT_NOINLINE void trace_few_lanes(const struct mlrt_job *job, uint32_t child, uint32_t lanes,
                                          struct lanes_search *search, struct mlrt_packet *packet,
                                          struct mlrt_worker *worker)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        const struct ray_rows rows = rows_of_lane(packet, &search->reciprocals, lane);
        trace_single(job, &rows, lane, child, packet, worker);
        if (job->any && packet->nearest.triangle[lane] != MLRT_NONE) search->alive &= ~(1u << lane);
    }
}

/* Traces those rays of a packet, which are in units, that are in `lanes`. */
static void trace_lanes_in_units(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                                 struct mlrt_worker *worker)
{
    const struct mlrt_bvh_node *nodes = job->tree->bvh.nodes;
    struct lanes_search search;
    uint32_t child = 0;
    begin_lanes(packet, lanes, &search);
    if (mlrt_count_bits(lanes) <= FEW_LANES) {
        trace_few_lanes(job, 0, lanes, &search, packet, worker);
        return;
    }
    COUNT(&worker->counters, packet_count, 1);
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        if (mlrt_bvh_quad_count(child) == 0) {
            push_lanes(packet, &nodes[mlrt_bvh_offset(child)], lanes, job->any, &search);
        } else {
            test_leaf_against_lanes(job, child, lanes, &search, packet, worker);
        }
        for (;;) {
            if (search.count == 0) return;
            const struct pending_lanes *top = &search.stack[--search.count];
            lanes = top->lanes & search.alive;
            if (!lanes) continue;
            if (!job->any) {
                uint32_t before = 0;
                for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
                    before |= m_bits(v_le(v_set1(top->near), v_load(packet->nearest.hi + v))) << v;
                }
                lanes &= before;
                if (!lanes) continue;
            }
            child = top->child;
            if (mlrt_count_bits(lanes) > FEW_LANES || mlrt_bvh_quad_count(child)) break;
            trace_few_lanes(job, child, lanes, &search, packet, worker);
        }
    }
}

/*
 * Traces those rays of a packet that are in `lanes`. They are brought into units first if the unit is not 1, or if a
 * direction has a component that is not safe, which only bundles carry.
 */
static MLRT_NOINLINE void trace_lanes(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                                      struct mlrt_worker *worker)
{
    const float unit = job->tree->bvh.unit;
    if (job->tree->bvh.node_count == 0 || !lanes) return;
    struct checked_lanes directions;
    check_lanes(packet->direction, &directions);
    if (MLRT_LIKELY(unit == 1 && !(lanes & ~directions.safe))) {
        trace_lanes_in_units(job, lanes, packet, worker);
        return;
    }
    struct mlrt_scaled_packet scaled;
    const uint32_t carried = scale_packet(lanes, unit, job->tree->bvh.reach, packet, &scaled);
    worker->scaled = &scaled;
    if (carried) trace_lanes_in_units(job, carried, &scaled.rays, worker);
    worker->scaled = NULL;
    take_scaled_hits(&scaled, carried);
    if (lanes & ~carried) mlrt_trace_in_double(job, lanes & ~carried, packet, worker, COUNTERS(worker));
}

#endif
