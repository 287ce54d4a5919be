/* SPDX-License-Identifier: MIT */
/*
 * Single rays, and results of rectangles: see finish.h.
 */
#include "hits/finish.h"

#include "job/structure.h"
#include "job/write_arrays.h"

void mlrt_trace_single_rays(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                            mlrt_counters *counters)
{
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

static void write_misses(struct mlrt_worker *worker, const struct mlrt_rectangle *area)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) mlrt_write_misses(area, worker->sinks.each[i]);
}

/* The last row of a list may be short; it is written by itself. */
void mlrt_write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
                               const struct mlrt_rectangle *tile)
{
    const uint64_t last = (uint64_t)(tile->y + tile->height - 1) * job->source.width + tile->x;
    struct mlrt_rectangle part = *tile;
    if (MLRT_UNLIKELY(last + tile->width > job->source.count)) {
        const struct mlrt_rectangle row = {tile->x, tile->y + tile->height - 1,
                                           last < job->source.count ? (uint32_t)(job->source.count - last) : 0, 1};
        write_misses(worker, &row);
        --part.height;
    }
    write_misses(worker, &part);
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
