/* SPDX-License-Identifier: MIT */
/*
 * What the kernels for the hierarchy of boxes do otherwise for rays of one direction (shear.h). Once for all of them,
 * four lanes wide: wider copies would be faster, but the library must stay small.
 */
#ifndef MLRT_SHEARED_H
#define MLRT_SHEARED_H

#include "bvh.h"
#include "kernels.h"
#include "packet.h"

#define MLRT_CELL_COUNT 16

/* Slopes that rays of cells lie between (cells.h). */
struct mlrt_slopes {
    MLRT_ALIGNED(64) float lo[MLRT_CELL_COUNT];
    MLRT_ALIGNED(64) float hi[MLRT_CELL_COUNT];
};

/*
 * The places of a parallel camera's cells (cells.h), between first and last columns, first and last rows: bit per cell
 * in `there`. `pad`: what rounding moves a ray by. Returns 0 if some rays are not at hand, or begin within the scene.
 */
int mlrt_set_sheared_slopes(const struct mlrt_shear *shear, const struct mlrt_view *view,
                            float samples[4][MLRT_CELL_COUNT], uint32_t there, const float pad[3],
                            struct mlrt_slopes slopes[2]);

/* Have the rays of a packet one direction? Those that float cannot carry, too: a shear forgets what theirs were. */
int mlrt_have_one_direction(const struct mlrt_packet *packet);

/* Is it that of a shear, if there is one? */
int mlrt_has_direction(const struct mlrt_packet *packet, const struct mlrt_shear *shear);

/*
 * Shears rays of the direction that the shear is for: directions, begin, lo and hi become what they are seen as, before
 * any hit. *begin becomes the least distance at which they begin, if it was larger; *limits_below 1 if some may begin
 * within the scene. Returns 0 if some are not at hand.
 */
int mlrt_shear_packet(const struct mlrt_shear *shear, struct mlrt_packet *packet, float *begin, int *limits_below);

/* Makes directions, lo and hi of a sheared packet what they were before. */
void mlrt_unshear_packet(struct mlrt_packet *packet);

/* children_met (bvh_tile.h) of cells between these slopes, from `begin` to `farthest`. */
uint32_t mlrt_sheared_children_met(const struct mlrt_shear *shear, const float slope_lo[2], const float slope_hi[2],
                                   float begin, float farthest, const struct mlrt_bvh_node *node,
                                   float near[MLRT_BVH_WIDTH]);

/*
 * Shears a box from `enter` to `exit` in depth: what it is between over the other axes, all relative to the centre.
 * Returns how near it is.
 */
float mlrt_shear_box(const struct mlrt_shear *shear, float enter, float exit, float begin[2], float end[2]);

/* Sets where the triangles of a leaf are seen (bvh_leaf.h). */
void mlrt_set_sheared_outlines(const struct mlrt_shear *shear, struct mlrt_leaf_setup *leaf);

/* Sets the terms of triangles among which those `wanted` are; returns those whose plane the direction may lie in. */
uint32_t mlrt_set_sheared_terms(const struct mlrt_shear *shear, uint32_t wanted, struct mlrt_leaf_setup *leaf);

#endif
