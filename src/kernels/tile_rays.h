/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets, for any source.
 */

static void read_packets(const struct mlrt_source *source, struct mlrt_ray_tile *tile)
{
    const int is_list = tile->column_bits == 0;
    int are_packed = has_packed_rays(source); /* until the first block that is not */
    uint32_t lanes[MLRT_CELL_COUNT] = {0}, checked = 0;
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        if (!mlrt_has_block(tile, place)) continue;
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        if (!is_list && place % 4 == 0) mlrt_prefetch_around(source, &tile->area, place);
        lanes[place] = mlrt_existing_lanes(source, &block);
        are_packed =
            are_packed && lanes[place] == 0xFFFF && read_packed_rays(source, block.x, block.y, &tile->packets[place]);
        if (are_packed) {
            checked |= 1u << place;
        } else {
            fetch_block(source, &block, lanes[place], &tile->packets[place]);
        }
    }
    struct known_mesh known = NO_MESH;
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        struct mlrt_packet *packet = &tile->packets[place];
        if (!mlrt_has_block(tile, place)) continue;
        if (!(checked >> place & 1)) {
            check_block(source, lanes[place], packet);
        } else if (packet->has_skip) {
            number_skips(source->tree, &known, packet);
        }
    }
}
