/* SPDX-License-Identifier: MIT */
/* Rectangles of a picture: tiles, and blocks of 4x4 rays. */
#ifndef MLRT_RAYS_RECTANGLE_H
#define MLRT_RAYS_RECTANGLE_H

#include "rays/source.h"

/* A part of a picture, or of a tile. */
struct mlrt_rectangle {
    uint32_t x;
    uint32_t y;
    uint32_t width;
    uint32_t height;
};

/* The piece of `whole` that starts at (x, y), relative to `whole`, and whose sides are at most `side`. */
MLRT_INLINE struct mlrt_rectangle mlrt_cut_piece(const struct mlrt_rectangle *whole, uint32_t x, uint32_t y,
                                                 uint32_t side)
{
    return (struct mlrt_rectangle){whole->x + x, whole->y + y, whole->width - x < side ? whole->width - x : side,
                                   whole->height - y < side ? whole->height - y : side};
}

/* The lanes of a block that exist: the last row of a list may be short. */
MLRT_INLINE uint32_t mlrt_existing_lanes(const struct mlrt_source *source, const struct mlrt_rectangle *block)
{
    const uint32_t lanes = mlrt_block_lanes(block->width, block->height);
    const uint64_t past = (uint64_t)(block->y + block->height - 1) * source->width + block->x + block->width;
    return MLRT_LIKELY(past <= source->count) ? lanes : mlrt_lanes_of_list(source, block->x, block->y, lanes);
}

/* The number of rays in a rectangle: the last row of a list may be short. */
static inline uint64_t mlrt_count_rays(const struct mlrt_source *source, const struct mlrt_rectangle *area)
{
    const uint64_t whole = (uint64_t)area->width * area->height;
    const uint64_t end = (uint64_t)(area->y + area->height - 1) * source->width + area->x + area->width;
    const uint64_t missing = end > source->count ? end - source->count : 0;
    return whole - (missing < area->width ? missing : area->width);
}

#endif
