/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets: see make_rays.h.
 */
#include "trace/make_rays.h"

#include "hits/finish.h"
#include "simd/sixteen.h"

/* Makes the rays of a picture's packet. */
static void make_picture_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
    tile->made |= 1u << place;
    mlrt_get_packet(job, &block, mlrt_existing_lanes(&job->source, &block), &tile->packets[place]);
}

uint32_t mlrt_find_seen(const struct mlrt_job *picture, struct mlrt_ray_tile *seen, uint32_t place)
{
    struct mlrt_packet *packet = &seen->packets[place];
    const struct mlrt_rectangle block = mlrt_block_of_tile(seen, place);
    const uint32_t lanes = mlrt_existing_lanes(&picture->source, &block);
    if (!(seen->made >> place & 1)) {
        make_picture_rays(picture, seen, place);
        mlrt_fill_words(packet->triangle, seen->cells->hulls.cover[place]);
    }
    return lanes & mlrt_lanes_with_hit(packet);
}

void mlrt_make_rays_to_light(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    struct mlrt_packet *packet = &tile->packets[place];
    const uint32_t hit = mlrt_find_seen(tile->picture, tile->seen, place);
    tile->dark[place] = 0;
    if (hit) {
        tile->dark[place] = job->kernels->make_shadow_packet(job, &tile->seen->packets[place], hit, packet);
        return;
    }
    packet->active = packet->single = 0;
    mlrt_fill_words(packet->triangle, MLRT_NONE);
}

void mlrt_make_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    if (!tile->seen) {
        make_picture_rays(job, tile, place);
        return;
    }
    tile->made |= 1u << place;
    mlrt_make_rays_to_light(job, tile, place);
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
