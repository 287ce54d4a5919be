/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets, for any source.
 */

/* Those that exist are active; nothing is checked. */
static void read_packets(const struct mlrt_source *source, struct mlrt_ray_tile *tile)
{
    for (uint32_t left = tile->blocks; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        struct mlrt_packet *packet = &tile->packets[place];
        const uint32_t lanes = mlrt_existing_lanes(source, &block);
        prefetch_row_of_blocks(source, tile, place);
        fetch_block(source, &block, lanes, packet);
        if (packet->has_skip) mlrt_number_skips(source->tree, packet);
        if (mlrt_is_pinhole(source)) continue;
        packet->active = lanes;
        packet->single = 0;
    }
}
