/* SPDX-License-Identifier: MIT */
/*
 * What the tile method works on: rectangles of a picture, the cells that go through the hierarchy of boxes together
 * (kernels/cells.h says what they are), and a tile of sixteen packets.
 */
#ifndef MLRT_TILE_H
#define MLRT_TILE_H

#include <math.h>
#include <string.h>

#include "kernels.h"
#include "tuning.h"

#define MLRT_CELL_COUNT 16

/* Slopes that rays of cells lie between (cells.h). */
struct mlrt_slopes {
    MLRT_ALIGNED(64) float lo[MLRT_CELL_COUNT];
    MLRT_ALIGNED(64) float hi[MLRT_CELL_COUNT];
};

/* A part of a picture, or of a tile. */
struct mlrt_rectangle {
    uint32_t x;
    uint32_t y;
    uint32_t width;
    uint32_t height;
};

/* The piece of `whole` that starts at (x, y) relative to it and has at most this side. */
MLRT_INLINE struct mlrt_rectangle mlrt_cut_piece(const struct mlrt_rectangle *whole, uint32_t x, uint32_t y,
                                                 uint32_t side)
{
    return (struct mlrt_rectangle){whole->x + x, whole->y + y, whole->width - x < side ? whole->width - x : side,
                                   whole->height - y < side ? whole->height - y : side};
}

/* Lanes of a block that exist: in the last row of a list some may not. */
MLRT_INLINE uint32_t mlrt_existing_lanes(const struct mlrt_source *source, const struct mlrt_rectangle *block)
{
    const uint32_t lanes = mlrt_block_lanes(block->width, block->height);
    const uint64_t past = (uint64_t)(block->y + block->height - 1) * source->width + block->x + block->width;
    return MLRT_LIKELY(past <= source->count) ? lanes : mlrt_lanes_of_list(source, block->x, block->y, lanes);
}

struct mlrt_cells {
    struct mlrt_slopes slopes[2]; /* over axes main + 1, main + 2; empty for cells that do not take part */
    MLRT_ALIGNED(64) float farthest[MLRT_CELL_COUNT]; /* depth; -inf: done */
    MLRT_ALIGNED(64) float shortest[MLRT_CELL_COUNT]; /* of closed cells: all rays reach this depth */
    MLRT_ALIGNED(64) uint32_t skip[MLRT_CELL_COUNT];  /* of closed cells: the triangle that all rays pass */
    MLRT_ALIGNED(64) float cover_near[MLRT_CELL_COUNT];
    MLRT_ALIGNED(64)
    uint32_t cover[MLRT_CELL_COUNT]; /* of a closed cell: the triangle; MLRT_NONE: nothing met so far */
    float apex[3];
    int main_axis;
    float sign;      /* of the main components: +-1 */
    uint32_t closed; /* bit per cell: no rays yet */
    /* Of all cells together. */
    float slope_lo[2];
    float slope_hi[2];
    float whole_farthest;
    float slope_bound;          /* of edge functions over slopes (bvh_leaf.h) */
    uint32_t few;               /* what no more cells than this meet may go to their rays one by one (hybrid.h) */
    struct mlrt_ray_tile *tile; /* whose packets the cells are; NULL: they are tiles */
};

/* The axis that slopes[side] of cells with this main axis are over. */
MLRT_INLINE int mlrt_slope_axis(int main_axis, int side)
{
    const int axis = main_axis + 1 + side;
    return axis < 3 ? axis : axis - 3;
}

/* Has cells see along the axis that a direction goes along most. */
static inline void mlrt_set_main_axis(const float direction[3], struct mlrt_cells *cells)
{
    const float x = fabsf(direction[0]), y = fabsf(direction[1]), z = fabsf(direction[2]);
    cells->main_axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    cells->sign = direction[cells->main_axis] < 0 ? -1.0f : 1.0f;
}

static inline void mlrt_set_cell_slopes(struct mlrt_cells *cells, uint32_t place, int side, float lo, float hi)
{
    cells->slopes[side].lo[place] = lo;
    cells->slopes[side].hi[place] = hi;
}

/* The main axis; ~axis if rays go down it. */
MLRT_INLINE int mlrt_axis_code(const struct mlrt_cells *cells)
{
    return cells->sign < 0 ? ~cells->main_axis : cells->main_axis;
}

/* Where the set-up of a leaf is kept, if it is. */
MLRT_INLINE uint32_t mlrt_place_of_leaf(uint32_t child, const struct mlrt_leaf_cache *cache)
{
    return mlrt_bvh_offset(child) * 0x9E3779B1u >> (32 - cache->bits);
}

MLRT_INLINE int mlrt_is_set_up(const struct mlrt_cells *cells, uint32_t child, const struct mlrt_leaf_cache *cache)
{
    const uint32_t place = mlrt_place_of_leaf(child, cache);
    return cache->children[place] == child && cache->leaves[place].axis == mlrt_axis_code(cells);
}

/* A cell that meets nothing. */
static inline void mlrt_leave_out_cell(struct mlrt_cells *cells, uint32_t place)
{
    cells->farthest[place] = -INFINITY;
    for (int side = 0; side < 2; ++side) mlrt_set_cell_slopes(cells, place, side, INFINITY, -INFINITY);
}

/* A child of a node as rays of cells see it. */
struct mlrt_seen_box {
    float nearest; /* depth */
    float first;   /* what slopes are multiplied with: depths, */
    float last;
    float begin[2]; /* to be compared with what the box is between over the other axes */
    float end[2];
};

static inline void mlrt_see_box(const struct mlrt_cells *cells, const struct mlrt_bvh_node *node, uint32_t place,
                                struct mlrt_seen_box *box)
{
    const int a = cells->main_axis;
    const float below = node->lo[a][place] - cells->apex[a], above = node->hi[a][place] - cells->apex[a];
    const float enter = cells->sign > 0 ? below : -above, exit = cells->sign > 0 ? above : -below;
    for (int side = 0; side < 2; ++side) {
        const int j = mlrt_slope_axis(a, side);
        box->begin[side] = node->lo[j][place] - cells->apex[j];
        box->end[side] = node->hi[j][place] - cells->apex[j];
    }
    box->nearest = box->first = enter > 0 ? enter : 0;
    box->last = exit;
}

/* A tile of sixteen packets: the rays of its cells, made when they are needed. */
struct mlrt_ray_tile {
    struct mlrt_cells cells;
    struct mlrt_rectangle area;
    uint32_t column_bits; /* of packets there are 1 << column_bits columns: 4, or 1 for a list */
    uint32_t blocks;      /* places that have one; those that are cut off count */
    struct mlrt_packet packets[MLRT_CELL_COUNT];
    float greatest_depth[MLRT_CELL_COUNT];             /* of the directions of a packet, along the main axis */
    int limits_below;                                  /* some t_min is not 0 */
    uint32_t made;                                     /* packets that have their rays */
    const struct mlrt_job *picture;                    /* of shadow rays: the call whose hits they come from, */
    struct mlrt_ray_tile *seen;                        /* and the tile with them; else NULL */
    struct mlrt_slopes ray_slopes[MLRT_CELL_COUNT][2]; /* by packet: of its rays, as if each were a cell (hybrid.h) */
    uint32_t has_ray_slopes;
    uint32_t tests[MLRT_CELL_COUNT]; /* of packets against triangles, in this traversal */
    uint32_t dark[MLRT_CELL_COUNT];  /* of shadow rays: lanes without one, as the light is on the other side */
};

/* The places of so many columns and rows of packets. */
MLRT_INLINE uint32_t mlrt_places(uint32_t column_bits, uint32_t columns, uint32_t rows)
{
    if (!columns) return 0;
    return column_bits ? (0xFu >> (4 - columns)) * (0x11110u >> 4 * (4 - rows) >> 4) : 0xFFFFu >> (16 - rows);
}

/* Has cells be packets of a tile; NULL: they are tiles. */
MLRT_INLINE void mlrt_set_tile(struct mlrt_ray_tile *tile, struct mlrt_cells *cells)
{
    cells->tile = tile;
    if (tile) memset(tile->tests, 0, sizeof tile->tests);
    cells->few = tile && mlrt_count_bits(tile->blocks) >= MLRT_MANY_PACKETS ? MLRT_FEW_PACKETS : 0;
}

/* A tile of which nothing is made; a list's has one column. */
MLRT_INLINE void mlrt_begin_tile(const struct mlrt_rectangle *area, int is_list, struct mlrt_ray_tile *tile)
{
    tile->area = *area;
    tile->column_bits = is_list ? 0 : 2;
    tile->blocks = mlrt_places(tile->column_bits, (area->width + 3) / 4, (area->height + 3) / 4);
    tile->limits_below = 0;
    tile->made = 0;
    tile->has_ray_slopes = 0;
    tile->seen = NULL;
}

/* The part of a tile that is at a place with a block. */
MLRT_INLINE struct mlrt_rectangle mlrt_block_of_tile(const struct mlrt_ray_tile *tile, uint32_t place)
{
    const uint32_t row = place >> tile->column_bits, column = place - (row << tile->column_bits);
    return mlrt_cut_piece(&tile->area, 4 * column, 4 * row, 4);
}

#endif
