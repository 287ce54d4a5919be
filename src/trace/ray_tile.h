/* SPDX-License-Identifier: MIT */
/*
 * What the tile method works on: a tile of sixteen packets.
 */
#ifndef MLRT_TRACE_RAY_TILE_H
#define MLRT_TRACE_RAY_TILE_H

#include "job/job.h"
#include "rays/rectangle.h"
#include "trace/bundle.h"

#define MLRT_CELL_COUNT MLRT_BUNDLE_PACKETS

/* A tile of sixteen packets: the rays of a bundle, made when they are needed. */
struct mlrt_ray_tile {
    struct mlrt_rectangle area;
    uint32_t column_bits;            /* of packets there are 1 << column_bits columns: 4, or 1 for a list */
    uint32_t blocks;                 /* places that have one; those that are cut off count */
    uint32_t made;                   /* packets that have their rays */
    const struct mlrt_job *picture;  /* of shadow rays: the call whose hits they come from, */
    struct mlrt_ray_tile *seen;      /* the tile with them, */
    const struct mlrt_bundle *cells; /* and what was found without rays; else NULL */
    uint32_t dark[MLRT_CELL_COUNT];  /* of shadow rays: lanes without one, as the light is on the other side */
    struct mlrt_packet packets[MLRT_CELL_COUNT];
    struct mlrt_bundle_rays rays[MLRT_CELL_COUNT];
    struct mlrt_reciprocals reciprocals[MLRT_CELL_COUNT];
};

/* The places of so many columns and rows of packets. */
MLRT_INLINE uint32_t mlrt_places(uint32_t column_bits, uint32_t columns, uint32_t rows)
{
    if (!columns) return 0;
    return column_bits ? (0xFu >> (4 - columns)) * (0x11110u >> 4 * (4 - rows) >> 4) : 0xFFFFu >> (16 - rows);
}

/* A tile of which nothing is made; a list's has one column. */
MLRT_INLINE void mlrt_begin_tile(const struct mlrt_rectangle *area, int is_list, struct mlrt_ray_tile *tile)
{
    tile->area = *area;
    tile->column_bits = is_list ? 0 : 2;
    tile->blocks = mlrt_places(tile->column_bits, (area->width + 3) / 4, (area->height + 3) / 4);
    tile->made = 0;
    tile->seen = NULL;
    tile->cells = NULL;
}

/* The part of a tile that is at a place with a block. */
MLRT_INLINE struct mlrt_rectangle mlrt_block_of_tile(const struct mlrt_ray_tile *tile, uint32_t place)
{
    const uint32_t row = place >> tile->column_bits, column = place - (row << tile->column_bits);
    return mlrt_cut_piece(&tile->area, 4 * column, 4 * row, 4);
}

#endif
