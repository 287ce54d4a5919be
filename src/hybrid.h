/* SPDX-License-Identifier: MIT */
/*
 * From packets to single rays, in the middle of the hierarchy: what is seen by few rays of a tile is not worth going
 * there together, nor a set-up for all of them.
 *
 * Based on: C. Benthin, I. Wald, S. Woop, M. Ernst, W. R. Mark, "Combining Single and Packet-Ray Tracing for Arbitrary
 * Ray Distributions on the Intel MIC Architecture", 2012 (packets that go on as single rays where few are left).
 */
#ifndef MLRT_HYBRID_H
#define MLRT_HYBRID_H

#include "tile.h"

/*
 * Traces the rays of packets `met`, few of those of a tile, through what is at `slot` (bvh_tile.h) of the hierarchy,
 * one by one, if few of them meet its box. Else does nothing and returns 0: also where there is nothing to spare, as a
 * leaf is set up already, or cells are closed.
 */
int mlrt_trace_few_rays(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_cells *cells, uint32_t slot,
                        uint32_t met);

/* Traces what is left of a packet ray by ray, through all of the hierarchy, and takes it out of its tile's traversal.
 */
void mlrt_trace_alone(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                      uint32_t place);

#endif
