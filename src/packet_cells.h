/* SPDX-License-Identifier: MIT */
/*
 * Cells of a tile's packets: from where they are seen, which packets go together, and which are too wide for that.
 */
#ifndef MLRT_PACKET_CELLS_H
#define MLRT_PACKET_CELLS_H

#include "tile.h"

/* Has all cells look along the main axis of a direction, from an apex. */
void mlrt_set_main_axis(const float direction[3], struct mlrt_cells *cells);

/* From where rays of one direction see things, one of which begins at `origin`. */
void mlrt_set_shear(const struct mlrt_job *job, const float direction[3], const float origin[3],
                    struct mlrt_cells *cells);

/*
 * Makes cells of the packets of `waiting` (bit per place) that can go together with the first of them, and returns
 * which. *wide receives those that are wider than *width, which is too much; or the first, if not even that can go.
 */
uint32_t mlrt_gather_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t waiting, uint32_t *wide,
                             float *width);

/* Of `lanes`, those whose slopes are at most half of `width` from those of the first. */
uint32_t mlrt_lanes_near_first(const struct mlrt_packet *packet, uint32_t lanes, int main_axis, float width);

#endif
