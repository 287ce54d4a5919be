/* SPDX-License-Identifier: MIT */
/* See trace_in_double.h. */
#include "hits/trace_in_double.h"

#include "job/stop.h"
#include "job/structure.h"
#include "job/read_lanes.h"

void mlrt_trace_in_double(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                          struct mlrt_worker *worker, mlrt_counters *counters)
{
    if (mlrt_is_stopped(worker, 0)) return;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        if (!packet->has.masks) ray.mask = job->source.common_mask;
        if (counters) ++counters->packet_count;
        packet->nearest.triangle[lane] = job->tree->structure->tracer.trace_ray(
            job->tree, &ray, packet->has.skip ? packet->skip[lane] : MLRT_NONE, job->any, NULL, counters);
    }
}
