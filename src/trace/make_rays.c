/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets: see make_rays.h.
 */
#include "trace/make_rays.h"

#include "hits/results.h"
#include "trace/shade.h"

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

void mlrt_finish_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet)
{
    if (packet->single) mlrt_trace_single_rays(job, packet->single, packet, &worker->counters);
}
