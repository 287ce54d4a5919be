/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets, for any source.
 */
#ifndef MLRT_TRACE_READ_TILE_H
#define MLRT_TRACE_READ_TILE_H

#include "rays/fetch_block.h"
#include "rays/read_arrays.h"
#include "trace/ray_tile.h"

/*
 * Reads the rays of all packets of a tile. Those of a pinhole camera are checked; of another source, all rays that
 * exist become active without a check. Returns the packets that have rays that are active, or in double.
 */
static uint32_t read_packets(const struct mlrt_source *source, struct mlrt_ray_tile *tile)
{
    struct known_mesh known = NO_MESH;
    struct mlrt_array_reader reader;
    uint32_t waiting = 0;
    const uint32_t whole = mlrt_begin_reading(source, &reader) ? mlrt_whole_places(source, tile) : 0;
    for (uint32_t left = tile->blocks; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        struct mlrt_packet *packet = &tile->packets[place];
        uint32_t lanes = 0xFFFF;
        if (MLRT_LIKELY(whole >> place & 1)) {
            const uint32_t row = place >> tile->column_bits, column = place - (row << tile->column_bits);
            read_whole_block(&reader, tile->area.x + 4 * column, tile->area.y + 4 * row, &known, packet);
        } else {
            const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
            lanes = mlrt_existing_lanes(source, &block);
            fetch_block(source, &block, lanes, packet);
        }
        if (!mlrt_is_pinhole(source)) {
            packet->active = lanes;
            packet->in_double = 0;
        }
        waiting |= ((packet->active | packet->in_double) != 0u) << place;
    }
    return waiting;
}

#endif
