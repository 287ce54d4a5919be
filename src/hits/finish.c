/* SPDX-License-Identifier: MIT */
/*
 * Single rays, and results of packets and rectangles: see finish.h.
 */
#include "hits/finish.h"

#include "hits/shadow_ray.h"
#include "job/structure.h"
#include "job/write_arrays.h"
#include "simd/sixteen.h"

void mlrt_trace_single_rays(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                            mlrt_counters *counters)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        if (!packet->has_masks) ray.mask = job->source.common_mask;
        if (counters) ++counters->packet_count;
        packet->triangle[lane] = job->tree->structure->tracer.trace_ray(
            job->tree, &ray, packet->has_skip ? packet->skip[lane] : MLRT_NONE, job->any, NULL, counters);
    }
}

static void write_misses(struct mlrt_worker *worker, const struct mlrt_rectangle *area)
{
    for (uint32_t i = 0; i < worker->sink_count; ++i) mlrt_write_misses(area, worker->sinks[i]);
}

/* The last row of a list may be short; it is written by itself. */
static void write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
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
    for (uint32_t i = 0; i < worker->sink_count; ++i) mlrt_write_same_shadow(shadow, tile, worker->sinks[i]);
}

void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block)
{
    for (uint32_t i = 0; i < worker->sink_count; ++i) mlrt_write_shadows(shadows, lanes, block, worker->sinks[i]);
}

void mlrt_end_packet(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t lanes,
                     const struct mlrt_rectangle *block, struct mlrt_packet *packet)
{
    if (packet->single) mlrt_trace_single_rays(job, packet->single, packet, &worker->counters);
    job->kernels->picture->write_packet(job, worker, packet, lanes, block);
    if (MLRT_LIKELY(!job->light_count)) return;
    uint8_t shadows[MLRT_PACKET_RAYS];
    mlrt_find_shadows(job, packet, lanes, shadows, &worker->counters);
    mlrt_write_packet_shadows(worker, shadows, lanes, block);
}

MLRT_NOINLINE void mlrt_trace_blocks(const struct mlrt_job *job, struct mlrt_worker *worker,
                                     const struct mlrt_rectangle *tile, const struct entry_list *list,
                                     mlrt_trace_block *trace_block)
{
    for (uint32_t j = 0; j < tile->height; j += 4) {
        for (uint32_t i = 0; i < tile->width; i += 4) {
            const struct mlrt_rectangle block = mlrt_cut_piece(tile, i, j, 4);
            trace_block(job, worker, &block, list);
        }
    }
}

static void trace_block(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *block,
                        const struct entry_list *list)
{
    const uint32_t lanes = mlrt_existing_lanes(&job->source, block);
    struct mlrt_packet packet;
    (void)list;
    mlrt_get_packet(job, block, lanes, &packet);
    packet.single |= packet.active;
    mlrt_end_packet(job, worker, lanes, block, &packet);
}

void mlrt_trace_by_rays(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile)
{
    worker->counters.ray_count += mlrt_count_rays(&job->source, tile);
    mlrt_trace_blocks(job, worker, tile, NULL, trace_block);
}

const struct mlrt_kernels mlrt_kernels_ray = {.trace_tile = mlrt_trace_by_rays, .picture = &mlrt_plain_picture};

/* Writes the hits of one triangle in a block if t, u, v or facing are wanted: these need rays. */
static void write_cover_numbers(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t number,
                                const struct mlrt_rectangle *block)
{
    struct mlrt_packet packet;
    const uint32_t lanes = mlrt_block_lanes(block->width, block->height);
    job->kernels->picture->fetch_block(&job->source, block, lanes, &packet);
    mlrt_fill_words(packet.triangle, number);
    job->kernels->picture->write_packet(job, worker, &packet, lanes, block);
}

/* Without channels for t, u, v and facing, no ray is made: all pixels get the same ids. */
void mlrt_write_closed(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t cover,
                       const struct mlrt_rectangle *tile)
{
    if (cover == MLRT_NONE) {
        write_picture_misses(job, worker, tile);
        return;
    }
    if (job->any) mlrt_write_picture_shadow(worker, 1, tile);
    if (!job->frame.numbers && !worker->tile.numbers) {
        for (uint32_t i = 0; i < worker->sink_count; ++i) {
            mlrt_write_same_ids(job->tree, cover, tile, worker->sinks[i]);
        }
        return;
    }
    for (uint32_t j = 0; j < tile->height; j += 4) {
        for (uint32_t i = 0; i < tile->width; i += 4) {
            const struct mlrt_rectangle block = mlrt_cut_piece(tile, i, j, 4);
            write_cover_numbers(job, worker, cover, &block);
        }
    }
}
