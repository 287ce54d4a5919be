/* SPDX-License-Identifier: MIT */
/* The rays of a block, of any source. */
#ifndef MLRT_RAYS_FETCH_BLOCK_H
#define MLRT_RAYS_FETCH_BLOCK_H

#include "rays/camera_packet.h"
#include "rays/check_packet.h"
#include "rays/rectangle.h"

/*
 * A block is read in two steps: fetch_block reads the numbers of its rays, check_block checks them. If many packets are
 * made, call fetch_block for all of them first. It stores in pieces what check_block loads as whole vectors; a load
 * that directly follows such stores has to wait for them.
 */
static void fetch_block(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                        struct mlrt_packet *packet)
{
    if (source->kind == MLRT_SOURCE_CAMERA) {
        get_camera_packet(&source->view, block->x, block->y, lanes, packet);
        if (MLRT_UNLIKELY(source->has_masks)) mlrt_fetch_masks(source, block->x, block->y, lanes, packet);
    } else {
        mlrt_fetch_packet(source, block->x, block->y, lanes, packet);
    }
}

static void check_block(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet)
{
    if (!mlrt_is_pinhole(source)) check_packet(lanes, packet);
}

#endif
