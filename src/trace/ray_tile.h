/* SPDX-License-Identifier: MIT */
/*
 * A tile of sixteen packets: the rays of a bundle, which are made when they are needed.
 */
#ifndef MLRT_TRACE_RAY_TILE_H
#define MLRT_TRACE_RAY_TILE_H

#include "hits/shadow_ray.h"
#include "job/job.h"
#include "rays/rectangle.h"
#include "trace/bundle.h"

/* Sets of packets have a bit per place. A tile of shadow rays refers to that of the picture's rays. */
struct mlrt_ray_tile {
    struct mlrt_rectangle area;
    uint32_t column_bits;               /* there are 1 << column_bits columns of packets: 4, or 1 for a list */
    uint32_t blocks;                    /* places with a block, whole or cut off by the edge of the picture */
    uint32_t made;                      /* packets that have their rays */
    const struct mlrt_job *picture;     /* the call whose hits the shadow rays come from */
    struct mlrt_ray_tile *seen;         /* the tile of the picture with these hits; NULL: this is such a tile */
    struct mlrt_kept_surface *surfaces; /* with `seen`: a table (shadow_ray.h) */
    const struct mlrt_bundle *cells;    /* the bundle with the covers of this tile's closed packets */
    uint32_t dark[MLRT_BUNDLE_PACKETS]; /* lanes without a shadow ray, because the light is behind the surface */
    struct mlrt_packet packets[MLRT_BUNDLE_PACKETS];
    struct mlrt_bundle_rays rays[MLRT_BUNDLE_PACKETS];
    struct mlrt_reciprocals reciprocals[MLRT_BUNDLE_PACKETS];
};

/* One bit for each packet in the first `columns` columns and `rows` rows; a list has one column of sixteen. */
MLRT_INLINE uint32_t mlrt_places(uint32_t column_bits, uint32_t columns, uint32_t rows)
{
    if (!columns) return 0;
    return column_bits ? (0xFu >> (4 - columns)) * (0x1111u >> 4 * (4 - rows)) : 0xFFFFu >> (16 - rows);
}

/* Begins a tile without rays. The tile of a list has one column of packets. */
MLRT_INLINE void mlrt_begin_tile(const struct mlrt_rectangle *area, int is_list, struct mlrt_ray_tile *tile)
{
    tile->area = *area;
    tile->column_bits = is_list ? 0 : 2;
    tile->blocks = mlrt_places(tile->column_bits, (area->width + 3) / 4, (area->height + 3) / 4);
    tile->made = 0;
    tile->seen = NULL;
    tile->cells = NULL;
}

/* The places of a tile whose blocks are whole: neither the edge of the picture nor the end of a list cuts them off. */
MLRT_INLINE uint32_t mlrt_whole_places(const struct mlrt_source *source, const struct mlrt_ray_tile *tile)
{
    const struct mlrt_rectangle *area = &tile->area;
    const uint64_t row_end = (uint64_t)area->x + area->width, first_end = (uint64_t)area->y * source->width + row_end;
    uint32_t height = area->height;
    if (MLRT_UNLIKELY(first_end + (uint64_t)(height - 1) * source->width > source->count)) { /* rows before the end */
        height = first_end > source->count ? 0 : (uint32_t)((source->count - first_end) / source->width + 1);
    }
    return mlrt_places(tile->column_bits, area->width / 4, height / 4);
}

/* The block of a tile at a place that has one. */
MLRT_INLINE struct mlrt_rectangle mlrt_block_of_tile(const struct mlrt_ray_tile *tile, uint32_t place)
{
    const uint32_t row = place >> tile->column_bits, column = place - (row << tile->column_bits);
    return mlrt_cut_piece(&tile->area, 4 * column, 4 * row, 4);
}

#endif
