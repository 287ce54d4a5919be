/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets: making them, and finishing what kernels leave.
 */
#ifndef MLRT_TRACE_MAKE_RAYS_H
#define MLRT_TRACE_MAKE_RAYS_H

#include "trace/ray_tile.h"

/* Makes the rays of the packet at a place: those of a picture, or from what its rays hit to a light. */
void mlrt_make_rays(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t place);

/* Makes those of all packets of a tile, for any source, and returns those that have rays. Whether these can hit anything
 * is not known yet. */
uint32_t mlrt_make_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile);

/* Done with a packet: traces its rays that float cannot carry. */
void mlrt_finish_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_packet *packet);

#endif
