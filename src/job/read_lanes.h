/* SPDX-License-Identifier: MIT */
/* What lanes of a packet have, for the judge and for the numbers of hits: a ray, corners, and its results. */
#ifndef MLRT_JOB_READ_LANES_H
#define MLRT_JOB_READ_LANES_H

#include "exact/quotients.h"
#include "job/write_arrays.h"
#include "rays/packet.h"
#include "scene/tree.h"

/* Sets *ray to the ray of a lane. If the packet has no masks, its mask is MLRT_MASK_ALL. */
void mlrt_get_segment(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_ray_segment *ray);

/*
 * Loads the corners of the triangles that the lanes `hit` have hit, as they were given: corners[i] has coordinate i of
 * all lanes. Lanes without a hit get the triangle of a lane that has one.
 */
void mlrt_gather_corners(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                         float corners[9][MLRT_PACKET_RAYS]);

/* Lets the judge compute t, u, v and facing of a lane with a hit. Numbers outside of `outputs` have no meaning. */
void mlrt_report_lane(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lane, uint32_t outputs,
                      struct mlrt_packet_values *values);

#endif
