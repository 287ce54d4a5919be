/* SPDX-License-Identifier: MIT */
/*
 * Makes the rays of a tile's packets.
 */
#ifndef MLRT_TRACE_MAKE_RAYS_H
#define MLRT_TRACE_MAKE_RAYS_H

#include "hits/blocks.h"
#include "hits/shadow_packet.h"
#include "simd/sixteen.h"
#include "trace/ray_tile.h"

/* Makes the rays of a picture's packet. */
static void make_picture_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
    tile->made |= 1u << place;
    get_packet(job, &block, mlrt_existing_lanes(&job->source, &block), &tile->packets[place]);
}

/* Returns the lanes of a picture's packet that hit a triangle. A closed packet without rays gets its rays first. */
static uint32_t find_seen(const struct mlrt_job *picture, struct mlrt_ray_tile *seen, uint32_t place)
{
    struct mlrt_packet *packet = &seen->packets[place];
    const struct mlrt_rectangle block = mlrt_block_of_tile(seen, place);
    const uint32_t lanes = mlrt_existing_lanes(&picture->source, &block);
    if (!(seen->made >> place & 1)) {
        make_picture_rays(picture, seen, place);
        mlrt_fill_words(packet->nearest.triangle, seen->cells->hulls.closed.cover[place]);
    }
    return lanes & ~lanes_of_triangle(packet, MLRT_NONE);
}

/*
 * Makes the rays of a tile's packet to the light of a job. If the packet of the picture has no rays yet, it gets them
 * first.
 */
static void make_rays_to_light(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    struct mlrt_packet *packet = &tile->packets[place];
    const uint32_t hit = find_seen(tile->picture, tile->seen, place);
    tile->dark[place] = 0;
    if (hit) {
        tile->dark[place] = make_shadow_packet(job, &tile->seen->packets[place], hit, tile->surfaces, packet);
        return;
    }
    packet->active = packet->in_double = 0;
    mlrt_fill_words(packet->nearest.triangle, MLRT_NONE);
}

/* Makes the rays of the packet at a place: those of a picture, or in a tile of shadow rays those to the light. */
static void make_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place)
{
    if (!tile->seen) {
        make_picture_rays(job, tile, place);
        return;
    }
    tile->made |= 1u << place;
    make_rays_to_light(job, tile, place);
}

#endif
