/* SPDX-License-Identifier: MIT */
/*
 * The levels of the tile method. A square of 64x64 pixels is a bundle of sixteen tiles of 16x16, and a tile is a bundle
 * of sixteen packets of 4x4. Tiles and packets that one triangle covers, or that meet none, are finished at once; the
 * others are cut further.
 *
 * Squares are bundles for pinhole cameras, and for any-hit rays of arrays with one origin or one direction. Other
 * sources begin with tiles.
 */
#ifndef MLRT_TRACE_LEVELS_H
#define MLRT_TRACE_LEVELS_H

#include "hits/blocks.h"
#include "job/stop.h"
#include "job/write_arrays.h"
#include "simd/sixteen.h"
#include "trace/array_cells.h"
#include "trace/camera_cells.h"
#include "trace/read_tile.h"
#include "trace/shadows.h"
#include "trace/tile.h"

/*
 * Makes a bundle without rays of the cells of `side` x `side` pixels of a camera's picture (camera_cells.c), or of the
 * tiles of arrays with one origin or one direction (array_cells.h). Returns 0 if that is not possible.
 */
static int gather_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area, uint32_t side,
                        struct mlrt_array_cells *arrays, struct mlrt_bundle *bundle)
{
    if (mlrt_is_pinhole(&job->source)) {
        return mlrt_is_within_reach(&job->tree->bvh, job->source.view.eye) &&
               mlrt_gather_camera_cells(&job->source.view, job->tree->bvh.unit, area, side, bundle);
    }
    if (arrays && job->source.kind != MLRT_SOURCE_CAMERA) return gather_array_cells(job, area, arrays, bundle);
    return 0;
}

/* Sets (*x, *y) to the corner of the tile after `tile`, where tiles go row by row through squares of 64 pixels. */
static void find_next_tile(const struct mlrt_source *source, const struct mlrt_rectangle *tile, uint32_t *x,
                           uint32_t *y)
{
    const uint32_t first = tile->x & ~63u;
    const int is_last = tile->x % 64 == 48 || tile->x + 16 >= source->width, is_lowest = tile->y % 64 == 48;
    *x = !is_last ? tile->x + 16 : is_lowest ? first + 64 : first;
    *y = !is_last ? tile->y : is_lowest ? tile->y & ~63u : tile->y + 16;
}

/*
 * Prefetches the places of the triangles that a packet hits: t, u and v are computed from the corners in leaves, which
 * the traversal has read, but it knows triangles by their numbers. A packet whose lanes all hit one triangle is left
 * out, since one cache miss costs little.
 */
MLRT_INLINE void prefetch_triangles(const struct mlrt_tree *tree, const struct mlrt_packet *packet)
{
    if (!tree->bvh.places || mlrt_same_words(packet->nearest.triangle, packet->nearest.triangle[0]) == 0xFFFF) return;
    for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const uint32_t number = packet->nearest.triangle[lane];
        if (number != MLRT_NONE) mlrt_prefetch(&tree->bvh.places[number]);
    }
}

/*
 * Traces the packets of a tile. Afterwards the packets in bundle->state.closed have a cover in place of rays; all
 * others have rays with their nearest hits.
 */
static void trace_packets(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle)
{
    struct mlrt_ray_tile *tile = bundle->tile;
    if (gather_cells(job, &tile->area, 4, NULL, bundle)) {
        const int is_open = mlrt_skips_attempt(&worker->bundles->open_tiles);
        trace_cells(job, worker, is_open, bundle);
        if (!is_open) mlrt_note_attempt(!bundle->state.closed, 1, MLRT_CELL_BACKOFF, &worker->bundles->open_tiles);
        return;
    }
    tile->made = 0xFFFF;
    const uint32_t waiting = read_packets(&job->source, tile);
    trace_bundle(job, worker, bundle, waiting);
    bundle->state.closed = 0;
}

/*
 * Writes the results of the packets of a tile, and prefetches rows of the next one: those of its rays, and of the
 * caller's arrays for their results. They lie too far apart for the processor's own prefetching, and only few cache
 * misses can be under way at once: so each packet that is written prefetches one row. A list has no rows, as it is read
 * in order.
 */
static MLRT_NOINLINE void write_packets(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        struct mlrt_ray_tile *tile, const struct mlrt_bundle *bundle)
{
    const int has_numbers = (job->frame.numbers | worker->sinks.tile.numbers) != 0;
    const uint32_t open = tile->blocks & ~bundle->state.closed, last_column = (1u << tile->column_bits) - 1;
    struct row_of_packets row = {.count = 0};
    struct mlrt_rows_ahead rows;
    uint32_t next_x, next_y;
    find_next_tile(&job->source, &tile->area, &next_x, &next_y);
    rows.height = 0;
    if (!mlrt_is_list(&job->source)) mlrt_begin_source_rows(&job->source, next_x, next_y, &rows);
    if (rows.height) {
        const uint32_t width = job->source.width - next_x;
        mlrt_add_sink_rows(&job->frame, next_x, next_y, width < 16 ? width : 16, &rows);
    }
    for (uint32_t left = tile->blocks; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left), ahead = place + 2;
        mlrt_prefetch_rows(&rows, place);
        if (has_numbers && open >> ahead & 1) prefetch_triangles(job->tree, &tile->packets[ahead]);
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        if (bundle->state.closed >> place & 1) {
            write_closed(job, worker, bundle->hulls.closed.cover[place], &block);
        } else {
            trace_rest_in_double(job, worker, &tile->packets[place]);
            add_to_row(&tile->packets[place], mlrt_existing_lanes(&job->source, &block), &block, &row);
        }
        const int has_neighbour = (place & last_column) != last_column && open >> place & 2;
        if (!has_neighbour) write_row(job, worker, &row);
    }
}

/* Traces a rectangle of at most 16 blocks. `known`: the tile is closed, with this cover and these lights; else NULL. */
static void trace_ray_tile(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area,
                           const struct known_lights *known)
{
    struct mlrt_ray_tile tile;
    struct mlrt_bundle bundle;
    mlrt_begin_tile(area, mlrt_is_list(&job->source), &tile);
    bundle.tile = &tile;
    bundle.state.closed = 0;
    tile.cells = &bundle;
    if (known) {
        gather_cells(job, area, 4, NULL, &bundle);
        mlrt_fill_words(bundle.hulls.closed.cover, known->cover);
        write_closed(job, worker, known->cover, area);
    } else {
        trace_packets(job, worker, &bundle);
        write_packets(job, worker, &tile, &bundle);
    }
    if (MLRT_UNLIKELY(job->light_count)) shade_tile(job, worker, &tile, known);
    (void)mlrt_is_stopped(worker, (double)area->width * area->height);
}

/* Traces a rectangle of at most 4 x 4 tiles. */
static void trace_square(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area)
{
    struct mlrt_bundle bundle;
    struct mlrt_array_cells arrays;
    bundle.tile = NULL;
    bundle.state.closed = 0;
    if (!mlrt_skips_attempt(&worker->bundles->open_squares)) {
        if (gather_cells(job, area, 16, &arrays, &bundle)) trace_cells(job, worker, 0, &bundle);
        const uint32_t least = job->source.kind == MLRT_SOURCE_CAMERA ? 1 : MLRT_READ_BACKOFF;
        mlrt_note_attempt(!bundle.state.closed, least, MLRT_SQUARE_BACKOFF, &worker->bundles->open_squares);
    }
    struct known_lights known[MLRT_BUNDLE_PACKETS];
    uint32_t known_cells = bundle.state.closed;
    if (MLRT_UNLIKELY(job->light_count) && bundle.state.closed) known_cells &= shade_cells(job, worker, &bundle, known);
    for (uint32_t j = 0; j < area->height; j += 16) {
        for (uint32_t i = 0; i < area->width; i += 16) {
            const struct mlrt_rectangle tile = mlrt_cut_piece(area, i, j, 16);
            const uint32_t place = j / 4 + i / 16, cover = bundle.hulls.closed.cover[place];
            if (known_cells >> place & 1) {
                write_closed(job, worker, cover, &tile);
                if (MLRT_UNLIKELY(job->light_count) && cover != MLRT_NONE) {
                    mlrt_write_picture_shadow(worker, known[place].dark, &tile);
                }
            } else {
                trace_ray_tile(job, worker, &tile, bundle.state.closed >> place & 1 ? &known[place] : NULL);
                if (worker->watch.stopped) return;
            }
        }
    }
}

/* Traces a part of a picture that starts at multiples of 4, and writes its results. */
static void trace_area(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area)
{
    if (job->method == MLRT_METHOD_RAY) {
        trace_by_rays(job, worker, area);
        return;
    }
    COUNT(&worker->counters, ray_count, mlrt_count_rays(&job->source, area));
    for (uint32_t j = 0; j < area->height; j += 64) {
        for (uint32_t i = 0; i < area->width; i += 64) {
            const struct mlrt_rectangle piece = mlrt_cut_piece(area, i, j, 64);
            if (mlrt_is_list(&job->source)) {
                trace_ray_tile(job, worker, &piece, NULL); /* four rays wide */
            } else {
                trace_square(job, worker, &piece);
            }
            if (worker->watch.stopped) return;
        }
    }
}

#endif
