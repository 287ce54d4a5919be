/* SPDX-License-Identifier: MIT */
/* See write_to_sinks.h. */
#include "hits/write_to_sinks.h"

#include "job/write_arrays.h"

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
