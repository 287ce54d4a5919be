/* SPDX-License-Identifier: MIT */
/*
 * The rays of a picture's blocks.
 */

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
    if (packet->has_apex || packet->has_masks) return; /* rays with masks go alone (tile_packets.c) */
    packet->has_direction = mlrt_is_parallel(source);
    if (packet->has_direction) return;
    find_apex(packet);
    packet->has_direction = !packet->has_apex && mlrt_have_one_direction(packet);
}
