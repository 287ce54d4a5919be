/* SPDX-License-Identifier: MIT */
/*
 * Single rays, and results of rectangles: see finish.h.
 */
#include "hits/finish.h"

#include "job/stop.h"
#include "job/structure.h"
#include "job/write_arrays.h"

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

/* The last row of a list may be short; it is written by itself. */
void mlrt_write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
                               const struct mlrt_rectangle *tile)
{
    const uint64_t ray_count = mlrt_count_rays(&job->source, tile);
    const uint32_t height = (uint32_t)(ray_count / tile->width), left = (uint32_t)(ray_count % tile->width);
    const struct mlrt_rectangle whole = {tile->x, tile->y, tile->width, height},
                                row = {tile->x, tile->y + height, left, 1};
    for (uint32_t i = 0; i < worker->sinks.count; ++i) {
        mlrt_write_misses(&whole, worker->sinks.each[i]);
        if (MLRT_UNLIKELY(left)) mlrt_write_misses(&row, worker->sinks.each[i]);
    }
}

void mlrt_write_picture_shadow(const struct mlrt_worker *worker, uint8_t shadow, const struct mlrt_rectangle *tile)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) mlrt_write_same_shadow(shadow, tile, worker->sinks.each[i]);
}

void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) mlrt_write_shadows(shadows, lanes, block, worker->sinks.each[i]);
}
