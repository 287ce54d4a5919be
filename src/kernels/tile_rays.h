/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets, for any source.
 */

static void read_packets(const struct mlrt_source *source, struct mlrt_ray_tile *tile)
{
    const uint32_t others = tile->blocks & ~read_packed_blocks(source, tile);
    uint32_t lanes[MLRT_CELL_COUNT];
    for (uint32_t left = others; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        prefetch_row_of_blocks(source, tile, place);
        lanes[place] = mlrt_existing_lanes(source, &block);
        fetch_block(source, &block, lanes[place], &tile->packets[place]);
    }
    for (uint32_t left = others; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        check_block(source, lanes[place], &tile->packets[place]);
    }
}
