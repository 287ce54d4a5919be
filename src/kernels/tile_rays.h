/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets, for any source.
 */

/* Makes all packets of a tile, and returns those with rays from one origin. Others are traced. */
static uint32_t make_packets(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile)
{
    uint32_t lanes[MLRT_CELL_COUNT] = {0}, waiting = 0;
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        if (!mlrt_has_block(tile, place)) continue;
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        if (tile->column_bits && place % 4 == 0 && place < 12)
            mlrt_prefetch_rays(&job->source, block.x, block.y + 4, 4);
        lanes[place] = mlrt_existing_lanes(&job->source, &block);
        fetch_block(&job->source, &block, lanes[place], &tile->packets[place]);
    }
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        if (!mlrt_has_block(tile, place)) continue;
        struct mlrt_packet *packet = &tile->packets[place];
        check_block(&job->source, lanes[place], packet);
        if (!job->tree->bvh.float_safe) {
            packet->single |= packet->active;
            packet->active = 0;
        }
        const int is_alike = packet->has_apex || (!packet->has_masks &&
                                                  (mlrt_is_parallel(&job->source) || mlrt_have_one_direction(packet)));
        if (packet->active && !is_alike) {
            trace_singles(job, packet->active, packet, worker);
        } else {
            waiting |= (packet->active != 0u) << place;
        }
    }
    return waiting;
}
