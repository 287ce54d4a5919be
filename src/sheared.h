/* SPDX-License-Identifier: MIT */
/*
 * What the kernels for the hierarchy of boxes do otherwise for rays of one direction (shear.h).
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

/* What the slack of shear.h is for, relative to itself: near and far of boxes and triangles. */
#define MLRT_SHEAR_DISTANCE_SLACK 0x1p-20f

struct mlrt_ray_tile;

/* There twice: for every processor of the kind, and for those that have AVX2. kernels/sheared_body.h */
struct mlrt_sheared_kernels {
    /*
     * add_packet (ray_tile.h) for cells that have a shear: directions, begin, lo and hi of the packet become what they
     * are seen as, before any hit. Returns 0 if some rays are not at hand, or they are wide: then the packet is no
     * cell, but sheared; or if its direction is too short, and then it is not.
     */
    int (*add_packet)(struct mlrt_ray_tile *tile, uint32_t place);
    /* children_met (bvh_tile.h) of cells between these slopes, from `begin` to `farthest`. */
    uint32_t (*children_met)(const struct mlrt_shear *shear, const float slope_lo[2], const float slope_hi[2],
                             float begin, float farthest, const struct mlrt_bvh_node *node, float near[MLRT_BVH_WIDTH]);
    /* Sets where the triangles of a leaf are seen (bvh_leaf.h). */
    void (*set_outlines)(const struct mlrt_shear *shear, struct mlrt_leaf_setup *leaf);
    /* Sets the terms of triangles among which those `wanted` are; returns those whose plane the direction may lie in.
     */
    uint32_t (*set_terms)(const struct mlrt_shear *shear, uint32_t wanted, struct mlrt_leaf_setup *leaf);
};

extern const struct mlrt_sheared_kernels mlrt_sheared_plain, mlrt_sheared_avx2;

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

/* Makes directions, lo and hi of a sheared packet what they were before. */
void mlrt_unshear_packet(struct mlrt_packet *packet);

/*
 * Shears a box from `enter` to `exit` in depth: what it is between over the other axes, all relative to the centre.
 * Returns how near it is.
 */
float mlrt_shear_box(const struct mlrt_shear *shear, float enter, float exit, float begin[2], float end[2]);

#endif
