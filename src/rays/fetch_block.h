/* SPDX-License-Identifier: MIT */
/*
 * The rays of a picture's blocks.
 */
#ifndef MLRT_RAYS_FETCH_BLOCK_H
#define MLRT_RAYS_FETCH_BLOCK_H

#include "rays/camera_packet.h"
#include "rays/check_packet.h"
#include "rays/rectangle.h"

/*
 * The rays of a block of any source, in two steps. Who makes many packets should take the first step for all of them:
 * what it stores in pieces, the second loads in whole vectors, for which it would have to wait.
 */
static void fetch_block(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                        struct mlrt_packet *packet)
{
    if (mlrt_is_pinhole(source)) {
        get_pinhole_packet(&source->view, block->x, block->y, lanes, packet);
        if (MLRT_UNLIKELY(source->has_masks)) mlrt_set_common_mask(source, packet);
    } else {
        mlrt_fetch_packet(source, block->x, block->y, lanes, packet);
    }
}

static void check_block(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet)
{
    if (mlrt_is_pinhole(source)) return;
    if (packet->has_skip) mlrt_number_skips(source->tree, packet);
    check_packet(lanes, packet);
}

#endif
