/* SPDX-License-Identifier: MIT */
/*
 * The packets of a tile, traced together as far as they can go together; what is too wide is cut.
 */

/* All rays of a packet whose cell stayed closed hit its cover. */
static void close_packets(struct ray_tile *tile)
{
    for (uint32_t left = tile->cells.closed; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        struct mlrt_packet *packet = &tile->packets[place];
        KEEP_LANES_LOOP
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            const vm active = m_from_bits(packet->active >> v);
            i_store(packet->triangle + v,
                    i_select(active, i_set1(tile->cells.cover[place]), i_load(packet->triangle + v)));
        }
    }
    tile->cells.closed = 0;
}

/*
 * Cuts packets that are too wide to go with the others: the rays near the first one are a cell, and the others are put
 * off. Where either are too few they go alone. Returns the new cells.
 */
static MLRT_SMALL uint32_t cut_wide_packets(const struct mlrt_job *job, struct mlrt_worker *worker,
                                            struct ray_tile *tile, uint32_t wide, float width,
                                            uint32_t put_off[CELL_COUNT])
{
    uint32_t cells = 0;
    for (; wide; wide &= wide - 1) {
        const uint32_t place = mlrt_lowest_bit(wide);
        struct mlrt_packet *packet = &tile->packets[place];
        const uint32_t near = lanes_near_first(packet, packet->active, tile->cells.main_axis, width);
        const uint32_t others = packet->active & ~near;
        const uint32_t alone = mlrt_count_bits(others) < MLRT_LEAST_PART ? others : 0;
        put_off[place] = others & ~alone;
        packet->active = near;
        if (alone) trace_singles(job, alone, packet, worker);
        if (mlrt_count_bits(near) >= MLRT_LEAST_PART && add_packet(tile, place)) {
            cells |= 1u << place;
        } else {
            trace_singles(job, near, packet, worker);
        }
    }
    return cells;
}

/* Traces packets down the hierarchy of boxes: together, as far as they can go together. */
static void trace_packets(const struct mlrt_job *job, struct mlrt_worker *worker, struct ray_tile *tile,
                          uint32_t waiting)
{
    uint32_t put_off[CELL_COUNT] = {0}, cut = 0;
    while (waiting) {
        uint32_t wide;
        float width;
        uint32_t gathered = gather_packets(job, tile, waiting, &wide, &width);
        waiting &= ~(gathered | wide);
        if (MLRT_UNLIKELY(wide)) {
            for (uint32_t again = wide & cut; again; again &= again - 1) {
                struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(again)];
                trace_singles(job, packet->active, packet, worker);
            }
            wide &= ~cut;
            cut |= wide;
            gathered |= cut_wide_packets(job, worker, tile, wide, width, put_off);
        }
        if (gathered) {
            sum_up_cells(&tile->cells);
            traverse_bvh(job, worker, &tile->cells);
            close_packets(tile);
            for (; are_sheared(&tile->cells) && gathered; gathered &= gathered - 1) {
                mlrt_unshear_packet(&tile->packets[mlrt_lowest_bit(gathered)]);
            }
        }
        for (; wide; wide &= wide - 1) {
            const uint32_t place = mlrt_lowest_bit(wide);
            tile->packets[place].active = put_off[place];
            waiting |= (put_off[place] != 0u) << place;
        }
    }
}

/* Done with the rays of a packet. */
static void finish_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet)
{
    if (packet->shear) mlrt_unshear_packet(packet);
    if (packet->single) trace_single_rays(job, packet->single, packet, &worker->counters);
}
