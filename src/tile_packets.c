/* SPDX-License-Identifier: MIT */
/*
 * Packets of a tile go together as far as they can; what is too wide is cut.
 */
#include "tile_packets.h"

#include "packet_cells.h"
#include "results.h"
#include "shade.h"

void mlrt_make_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
    tile->made |= 1u << place;
    if (tile->seen) {
        mlrt_make_rays_to_light(job, tile, place);
    } else {
        mlrt_get_packet(job, &block, mlrt_existing_lanes(&job->source, &block), &tile->packets[place]);
    }
}

uint32_t mlrt_make_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile)
{
    uint32_t waiting = 0;
    job->kernels->picture->read_packets(&job->source, tile);
    for (uint32_t left = tile->blocks; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        waiting |= ((tile->packets[place].active | tile->packets[place].single) != 0u) << place;
    }
    return waiting;
}

/*
 * Cuts packets that are too wide to go with the others: the rays near the first one are a cell, and the others are put
 * off. Where either are too few they go alone. Returns the new cells.
 */
static uint32_t cut_wide_packets(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                                 uint32_t wide, float width, uint32_t put_off[MLRT_CELL_COUNT])
{
    uint32_t cells = 0;
    for (; wide; wide &= wide - 1) {
        const uint32_t place = mlrt_lowest_bit(wide);
        struct mlrt_packet *packet = &tile->packets[place];
        const uint32_t near = mlrt_lanes_near_first(packet, packet->active, tile->cells.main_axis, width);
        const uint32_t others = packet->active & ~near;
        const uint32_t alone = mlrt_count_bits(others) < MLRT_LEAST_PART ? others : 0;
        put_off[place] = others & ~alone;
        packet->active = near;
        if (alone) job->kernels->trace_singles(job, alone, packet, worker, 0);
        if (mlrt_count_bits(near) >= MLRT_LEAST_PART && job->kernels->add_packet(tile, place)) {
            cells |= 1u << place;
        } else {
            job->kernels->trace_singles(job, near, packet, worker, 0);
        }
    }
    return cells;
}

static void unshear_packets(struct mlrt_ray_tile *tile, uint32_t places)
{
    for (; places; places &= places - 1) {
        struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(places)];
        if (packet->shear) mlrt_unshear_packet(packet);
    }
}

/* Traces packets down the hierarchy of boxes: together, as far as they can go together. */
void mlrt_trace_packets(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                        uint32_t waiting)
{
    uint32_t put_off[MLRT_CELL_COUNT] = {0}, cut = 0;
    while (waiting) {
        uint32_t wide;
        float width;
        uint32_t gathered = mlrt_gather_packets(job, tile, waiting, &wide, &width);
        waiting &= ~(gathered | wide);
        if (MLRT_UNLIKELY(wide)) {
            for (uint32_t again = wide & cut; again; again &= again - 1) {
                struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(again)];
                job->kernels->trace_singles(job, packet->active, packet, worker, 0);
            }
            wide &= ~cut;
            cut |= wide;
            gathered |= cut_wide_packets(job, worker, tile, wide, width, put_off);
        }
        if (gathered) {
            job->kernels->trace_gathered(job, worker, tile);
            if (waiting | wide) unshear_packets(tile, gathered); /* the next may have another shear */
        }
        for (; wide; wide &= wide - 1) {
            const uint32_t place = mlrt_lowest_bit(wide);
            tile->packets[place].active = put_off[place];
            waiting |= (put_off[place] != 0u) << place;
        }
    }
}

void mlrt_finish_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet)
{
    if (packet->shear && (packet->single || !job->any)) mlrt_unshear_packet(packet);
    if (packet->single) mlrt_trace_single_rays(job, packet->single, packet, &worker->counters);
}
