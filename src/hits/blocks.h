/* SPDX-License-Identifier: MIT */
/*
 * Blocks of 4x4 rays: made, traced one by one in double (method ray), and written. And rectangles of a picture that one
 * triangle covers, or that miss.
 */
#ifndef MLRT_HITS_BLOCKS_H
#define MLRT_HITS_BLOCKS_H

#include "base/counters.h"
#include "hits/shadow_ray.h"
#include "hits/trace_in_double.h"
#include "hits/write_packet.h"
#include "hits/write_to_sinks.h"
#include "rays/fetch_block.h"
#include "simd/sixteen.h"

/* Makes the rays of a block, and checks them. `lanes` are those that exist. */
MLRT_INLINE void get_packet(const struct mlrt_job *job, const struct mlrt_rectangle *block, uint32_t lanes,
                            struct mlrt_packet *packet)
{
    fetch_block(&job->source, block, lanes, packet);
    check_block(&job->source, lanes, packet);
}

/* Traces the rays of a packet that float does not carry. */
static void trace_rest_in_double(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet)
{
    if (MLRT_UNLIKELY(packet->in_double != 0))
        mlrt_trace_in_double(job, packet->in_double, packet, worker, COUNTERS(worker));
}

/* Traces the rays of a packet that go in double, and writes the results of all, and their shadows. */
static void end_packet(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t lanes,
                       const struct mlrt_rectangle *block, struct mlrt_packet *packet)
{
    trace_rest_in_double(job, worker, packet);
    write_packet(job, worker, packet, lanes, block);
    if (MLRT_LIKELY(!job->light_count)) return;
    uint8_t shadows[MLRT_PACKET_RAYS];
    mlrt_find_shadows(job, packet, lanes, shadows, COUNTERS(worker));
    mlrt_write_packet_shadows(worker, shadows, lanes, block);
}

/* Traces a block of at most 4x4 rays, and writes their results. `list` is what they start from, in a kd-tree. */
struct entry_list;
typedef void block_function(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *block,
                            const struct entry_list *list);

MLRT_INLINE void trace_blocks(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile,
                              const struct entry_list *list, block_function *trace_each)
{
    for (uint32_t j = 0; j < tile->height; j += 4) {
        for (uint32_t i = 0; i < tile->width; i += 4) {
            const struct mlrt_rectangle block = mlrt_cut_piece(tile, i, j, 4);
            trace_each(job, worker, &block, list);
        }
    }
}

static void trace_block_by_rays(const struct mlrt_job *job, struct mlrt_worker *worker,
                                const struct mlrt_rectangle *block, const struct entry_list *list)
{
    const uint32_t lanes = mlrt_existing_lanes(&job->source, block);
    struct mlrt_packet packet;
    (void)list;
    get_packet(job, block, lanes, &packet);
    packet.in_double |= packet.active;
    end_packet(job, worker, lanes, block, &packet);
}

/* Method ray: traces all rays of a tile one by one in double. */
static MLRT_NOINLINE void trace_by_rays(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        const struct mlrt_rectangle *tile)
{
    COUNT(&worker->counters, ray_count, mlrt_count_rays(&job->source, tile));
    trace_blocks(job, worker, tile, NULL, trace_block_by_rays);
}

/*
 * Writes the hits of one triangle in up to four rows of at most 16 columns, if t, u, v or facing are wanted: these need
 * rays.
 */
static void write_cover_numbers(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t number,
                                const struct mlrt_rectangle *rows)
{
    struct mlrt_packet packets[PACKETS_OF_ROW];
    struct row_of_packets row = {.count = 0};
    for (uint32_t i = 0; i < rows->width; i += 4) {
        const struct mlrt_rectangle block = mlrt_cut_piece(rows, i, 0, 4);
        const uint32_t lanes = mlrt_block_lanes(block.width, block.height);
        struct mlrt_packet *packet = &packets[row.count];
        fetch_block(&job->source, &block, lanes, packet);
        mlrt_fill_words(packet->nearest.triangle, number);
        add_to_row(packet, lanes, &block, &row);
    }
    write_row(job, worker, &row);
}

/*
 * Writes hits of one triangle to a rectangle of a picture, or misses if `cover` is MLRT_NONE. With hits, a picture with
 * lights keeps its values of `occluded`. Without channels for t, u, v and facing, no ray is made: all pixels get the
 * same ids.
 */
static MLRT_NOINLINE void write_closed(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t cover,
                                       const struct mlrt_rectangle *tile)
{
    if (cover == MLRT_NONE) {
        mlrt_write_picture_misses(job, worker, tile);
        return;
    }
    if (job->any) mlrt_write_picture_shadow(worker, 1, tile);
    if (!job->frame.numbers && !worker->sinks.tile.numbers) {
        for (uint32_t i = 0; i < worker->sinks.count; ++i)
            mlrt_write_same_ids(job->tree, cover, tile, worker->sinks.each[i]);
        return;
    }
    for (uint32_t j = 0; j < tile->height; j += 4) {
        for (uint32_t i = 0; i < tile->width; i += 4 * PACKETS_OF_ROW) {
            const struct mlrt_rectangle piece = mlrt_cut_piece(tile, i, j, 4 * PACKETS_OF_ROW);
            const struct mlrt_rectangle rows = {piece.x, piece.y, piece.width, piece.height < 4 ? piece.height : 4};
            write_cover_numbers(job, worker, cover, &rows);
        }
    }
}

#endif
