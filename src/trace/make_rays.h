/* SPDX-License-Identifier: MIT */
/*
 * Makes the rays of a tile's packets, and traces those that the kernels leave.
 */
#ifndef MLRT_TRACE_MAKE_RAYS_H
#define MLRT_TRACE_MAKE_RAYS_H

#include "simd/sixteen.h"
#include "trace/ray_tile.h"

/* The lanes of a packet that hit a triangle. */
static inline uint32_t mlrt_lanes_with_hit(const struct mlrt_packet *packet)
{
    return ~mlrt_same_words(packet->triangle, MLRT_NONE) & 0xFFFF;
}

/* Returns the lanes of a picture's packet that hit a triangle. A closed packet without rays gets its rays first. */
uint32_t mlrt_find_seen(const struct mlrt_job *picture, struct mlrt_ray_tile *seen, uint32_t place);

/*
 * Makes the rays of a tile's packet to the light of a job. If the packet of the picture has no rays yet, it gets them
 * first.
 */
void mlrt_make_rays_to_light(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place);

/* Makes the rays of the packet at a place: those of a picture, or in a tile of shadow rays those to the light. */
void mlrt_make_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place);

/*
 * Makes the rays of all packets of a tile, for any source. Returns the packets that have rays: not all of these rays
 * can hit something, since only those of a pinhole camera are checked.
 */
uint32_t mlrt_make_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile);

/* Traces the rays of a packet that float does not carry. */
void mlrt_finish_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet);

#endif
