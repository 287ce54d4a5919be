/* SPDX-License-Identifier: MIT */
/*
 * The levels: each tile has a beam, and each beam an entry point. The tile is cut into smaller tiles, which search for
 * entry points of their own from there. Tiles of the smallest size are traced as packets of 4x4 rays from theirs.
 *
 * A tile whose rays differ in sign has no beam. It is cut as well, and its pieces start where it started.
 *
 * Based on: Reshetov et al. 2005, section 4.2.
 */
#ifndef MLRT_MLRTA_LEVELS_H
#define MLRT_MLRTA_LEVELS_H

#include <string.h>

#include "base/counters.h"
#include "hits/blocks.h"
#include "mlrta/beam.h"
#include "mlrta/entry_point.h"
#include "mlrta/interval_traversal.h"
#include "mlrta/masked_traversal.h"
#include "mlrta/triangle_setup.h"

MLRT_INLINE void trace_active(const struct mlrt_job *job, const struct entry_list *list, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    if (packet->has.apex && memcmp(packet->apex, worker->setups->apex, sizeof packet->apex) != 0)
        forget_setups(packet->apex, worker);
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
    set_far_rays_aside(job->tree->kdtree.reach, &packet);
    if (packet.active) trace_active(job, list, &packet, worker);
    end_packet(job, worker, lanes, block, &packet);
}

/* Counts the nodes of `list` and traces the rays of a tile from them. */
static void enter_tile(const struct mlrt_job *job, struct mlrt_worker *worker, const struct entry_list *list,
                       const struct mlrt_rectangle *tile)
{
    for (uint32_t i = 0; i < list->count; ++i) {
        ++worker->counters.entry_point_count;
        worker->counters.entry_point_depth_sum += list->entries[i].depth;
    }
    trace_blocks(job, worker, tile, list, trace_block);
}

/* Sets the outlines of a list's entries, if the beam has an apex. */
static void set_entry_outlines(const struct mlrt_beam *beam, struct entry_list *list)
{
    if (!beam->has_apex) return;
    list->axis_code = axis_code_of(beam->main_axis, beam->negative[beam->main_axis]);
    for (uint32_t i = 0; i < list->count; ++i)
        set_box_outline(&list->entries[i].box, list->axis_code, beam->origin_lo, &list->outlines[i]);
}

/*
 * Traces a tile whose sides are at most `size`, and whose rays may all start at `above`. Tiles of the smallest size
 * enter the tree where they may start; others do if that is a leaf, and are cut if not.
 */
static void trace_level(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile,
                        uint32_t size, const struct entry_point *above)
{
    const int is_last = size <= job->multilevel.minimum_tile_size;
    const int has_list = is_last && job->multilevel.shortcuts & MLRT_SHORTCUT_ENTRY_LISTS;
    struct mlrt_beam beam;
    struct entry_list list;
    struct entry_point *entry = &list.entries[0];
    int is_entered = is_last;
    list.count = 1;
    list.axis_code = NO_OUTLINES;
    *entry = *above;
    if (mlrt_get_beam(&job->source, tile->x, tile->y, tile->width, tile->height, &beam)) {
        uint32_t cover;
        const int enters = has_list ? mlrt_find_entry_list(job, &beam, *above, &list, &cover, &worker->counters)
                                    : mlrt_find_entry_point(job, &beam, entry, &cover, &worker->counters);
        if (!enters) {
            ++*(cover == MLRT_NONE ? &worker->counters.missed_beam_count : &worker->counters.covered_beam_count);
            write_closed(job, worker, cover, tile);
            return;
        }
        if (has_list) set_entry_outlines(&beam, &list);
        is_entered |= mlrt_node_is_leaf(&job->tree->kdtree.nodes[entry->node]);
    }
    if (is_entered) {
        enter_tile(job, worker, &list, tile);
        return;
    }
    uint32_t side = size / job->multilevel.split_divisor;
    if (side < job->multilevel.minimum_tile_size) side = job->multilevel.minimum_tile_size;
    for (uint32_t j = 0; j < tile->height; j += side) {
        for (uint32_t i = 0; i < tile->width; i += side) {
            const struct mlrt_rectangle piece = mlrt_cut_piece(tile, i, j, side);
            trace_level(job, worker, &piece, side, entry);
        }
    }
}

/* Traces a part of a picture that starts at multiples of 4, and writes its results. */
static void trace_kdtree_area(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile)
{
    struct entry_list root;
    if (job->method == MLRT_METHOD_RAY || !job->tree->kdtree.float_safe) {
        trace_by_rays(job, worker, tile);
        return;
    }
    root.count = 1;
    root.axis_code = NO_OUTLINES;
    root.entries[0] = (struct entry_point){0, 0, job->tree->bounds};
    COUNT(&worker->counters, ray_count, mlrt_count_rays(&job->source, tile));
    if (job->method == MLRT_METHOD_MULTILEVEL)
        trace_level(job, worker, tile, job->initial_tile_size, &root.entries[0]);
    else
        trace_blocks(job, worker, tile, &root, trace_block);
}

#endif
