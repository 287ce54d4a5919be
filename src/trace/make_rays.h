/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets: making them, and finishing what kernels leave.
 */
#ifndef MLRT_TRACE_MAKE_RAYS_H
#define MLRT_TRACE_MAKE_RAYS_H

#include "simd/sixteen.h"
#include "trace/ray_tile.h"

/* The lanes of a packet that hit something. */
static inline uint32_t mlrt_lanes_with_hit(const struct mlrt_packet *packet)
{
    return ~mlrt_same_words(packet->triangle, MLRT_NONE) & 0xFFFF;
}

/* Which lanes of a picture's packet hit something. The rays of one that is closed are made, if they are not there. */
uint32_t mlrt_find_seen(const struct mlrt_job *picture, struct mlrt_ray_tile *seen, uint32_t place);

/* Makes the rays of a tile's packet to the light of a job; those of the picture, too, if it has none yet. */
void mlrt_make_rays_to_light(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place);

/* Makes the rays of the packet at a place: those of a picture, or from what its rays hit to a light. */
void mlrt_make_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place);

/* Makes those of all packets of a tile, for any source, and returns those that have rays. Whether these can hit anything
 * is not known yet. */
uint32_t mlrt_make_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile);

/* Done with a packet: traces its rays that float cannot carry. */
void mlrt_finish_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet);

#endif
