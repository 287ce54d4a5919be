/* SPDX-License-Identifier: MIT */
/*
 * Parts of a picture, and the rays of its blocks.
 */

/* A part of a picture, or of a tile. */
struct rectangle {
    uint32_t x;
    uint32_t y;
    uint32_t width;
    uint32_t height;
};

/* The piece of `whole` that starts at (x, y) relative to it and has at most this side. */
MLRT_INLINE struct rectangle cut_piece(const struct rectangle *whole, uint32_t x, uint32_t y, uint32_t side)
{
    return (struct rectangle){whole->x + x, whole->y + y, whole->width - x < side ? whole->width - x : side,
                              whole->height - y < side ? whole->height - y : side};
}

/* Of the lanes of a block at the end of a list, those that exist. */
static MLRT_SMALL uint32_t lanes_of_list(const struct mlrt_source *source, const struct rectangle *block,
                                         uint32_t lanes)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const uint64_t row = block->y + (uint32_t)mlrt_lane_y[lane];
        if (row * source->width + block->x + (uint32_t)mlrt_lane_x[lane] >= source->count) lanes &= ~(1u << lane);
    }
    return lanes;
}

/* Lanes of a block that exist: in the last row of a list some may not. */
MLRT_INLINE uint32_t existing_lanes(const struct mlrt_source *source, const struct rectangle *block)
{
    const uint32_t lanes = mlrt_block_lanes(block->width, block->height);
    const uint64_t past = (uint64_t)(block->y + block->height - 1) * source->width + block->x + block->width;
    return MLRT_LIKELY(past <= source->count) ? lanes : lanes_of_list(source, block, lanes);
}

MLRT_INLINE int is_pinhole(const struct mlrt_source *source)
{
    return source->kind == MLRT_SOURCE_CAMERA && !source->view.parallel;
}

/*
 * The rays of a block of any source, in two steps. Who makes many packets should take the first step for all of them:
 * what it stores in pieces, the second loads in whole vectors, for which it would have to wait.
 */
MLRT_INLINE void fetch_block(const struct mlrt_source *source, const struct rectangle *block, uint32_t lanes,
                             struct mlrt_packet *packet)
{
    if (is_pinhole(source)) {
        get_pinhole_packet(&source->view, block->x, block->y, lanes, packet);
        if (MLRT_UNLIKELY(source->has_masks)) mlrt_set_common_mask(source, packet);
    } else {
        mlrt_fetch_packet(source, block->x, block->y, lanes, packet);
    }
}

static void check_block(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet)
{
    if (is_pinhole(source)) return;
    if (packet->has_skip) number_skips(source->tree, packet);
    check_packet(lanes, packet);
    /* Rays with masks go alone (bvh_tile.h). */
    if (!packet->has_apex && !packet->has_masks && !mlrt_is_parallel(source)) find_apex(packet);
}

/* The rays of a block. `lanes` are those that exist. */
static MLRT_NOINLINE void get_packet(const struct mlrt_source *source, const struct rectangle *block, uint32_t lanes,
                       struct mlrt_packet *packet)
{
    fetch_block(source, block, lanes, packet);
    check_block(source, lanes, packet);
}
