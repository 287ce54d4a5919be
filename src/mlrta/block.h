/* SPDX-License-Identifier: MIT */
/*
 * A block of 4x4 rays: its rays are made, traced as a packet from the nodes where the tile may start, and written.
 */
#ifndef MLRT_MLRTA_BLOCK_H
#define MLRT_MLRTA_BLOCK_H

#include <string.h>

#include "base/counters.h"
#include "hits/blocks.h"
#include "mlrta/interval_traversal.h"
#include "mlrta/masked_traversal.h"
#include "mlrta/triangle_setup.h"

MLRT_INLINE void trace_active(const struct mlrt_job *job, const struct entry_list *list, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    if (packet->has.apex && memcmp(packet->apex, worker->setups->apex, sizeof packet->apex) != 0) {
        forget_setups(packet->apex, worker);
    }
    if (VW <= 4 && job->method == MLRT_METHOD_PACKET2) { /* run/dispatch.c: wider kernels never get this method */
        traverse_masked(job, packet, worker);
    } else {
        traverse_interval(job, list, packet, worker);
    }
}

/* Traces a block of at most 4x4 rays from the nodes of `list` and writes the results. */
static void trace_block(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *block,
                        const struct entry_list *list)
{
    const uint32_t lanes = mlrt_existing_lanes(&job->source, block);
    struct mlrt_packet packet;
    get_packet(job, block, lanes, &packet);
    if (packet.active) trace_active(job, list, &packet, worker);
    end_packet(job, worker, lanes, block, &packet);
}

#endif
