/* SPDX-License-Identifier: MIT */
/*
 * A packet: sixteen rays as arrays, which the kernels trace together.
 *
 * Lanes 4q .. 4q + 3 are a square of 2x2 pixels, and the four squares make one of 4x4: lane l is the pixel
 * (mlrt_lane_x[l], mlrt_lane_y[l]) of its block. So one layout serves packets of both sizes.
 *
 * A ray is `active` if float arithmetic carries its numbers without overflow or loss. On the kd-tree, its direction
 * components and origin coordinates, and the coordinates of the tree (float_safe in scene/tree.h), must be 0 or of
 * magnitude 2^-60 .. 2^60; in the hierarchy of boxes they must be so in its units (trace/units.h), and the origin
 * within reach (scene/reach.h). Other rays that can hit a triangle are `in_double`: they go through the tree one by one
 * in double.
 */
#ifndef MLRT_RAYS_PACKET_H
#define MLRT_RAYS_PACKET_H

#include <stddef.h>
#include <stdint.h>

#include "base/platform.h"

#define MLRT_PACKET_RAYS 16

/*
 * Bounds of reciprocals are moved apart by this share of themselves: more than what roundings change
 * (mlrta/interval_traversal.h, trace/single_ray_boxes.h). SLOPE_SLACK in slope_limits.h is that of slopes.
 */
#define RECIPROCAL_SLACK 0x1p-21f

/* The nearest hit so far of each ray, as in struct mlrt_nearest. */
struct mlrt_packet_hits {
    MLRT_ALIGNED(64) float lo[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float hi[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t triangle[MLRT_PACKET_RAYS];
};

/* What the rays of a packet have. */
struct mlrt_packet_traits {
    int apex;   /* all rays start at one point */
    int skip;   /* rays may each have a triangle that they pass through */
    int limits; /* 0 = all t_min are 0 or less, and all t_max are equal */
    int masks;  /* 0 = the rays see all triangles, or have the mask of the worker (job/job.h) */
};

struct mlrt_packet {
    MLRT_ALIGNED(64) float direction[3][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float origin[3][MLRT_PACKET_RAYS]; /* not set if has.apex */
    MLRT_ALIGNED(64) float t_min[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float t_max[MLRT_PACKET_RAYS];
    struct mlrt_packet_hits nearest;
    MLRT_ALIGNED(64) uint32_t skip[MLRT_PACKET_RAYS]; /* triangle number, MLRT_NONE = none; not set if !has.skip */
    MLRT_ALIGNED(64) uint32_t mask[MLRT_PACKET_RAYS]; /* scene/masks.h; not set if !has.masks */
    float apex[3];                                    /* the common origin, if has.apex */
    uint32_t active;                                  /* bit per lane */
    uint32_t in_double;                               /* bit per lane */
    struct mlrt_packet_traits has;
};

/* The powers of two of each lane (struct mlrt_ray_powers), for trace/units.h. */
struct mlrt_ray_scales {
    MLRT_ALIGNED(64) float direction[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float time[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float inverse_time[MLRT_PACKET_RAYS];
};

struct mlrt_scaled_packet {
    struct mlrt_packet rays;   /* in units */
    struct mlrt_packet *given; /* the packet that `rays` was made of */
    struct mlrt_ray_scales scales;
};

static const MLRT_ALIGNED(64) float mlrt_lane_x[MLRT_PACKET_RAYS] = {0, 1, 0, 1, 2, 3, 2, 3, 0, 1, 0, 1, 2, 3, 2, 3};
static const MLRT_ALIGNED(64) float mlrt_lane_y[MLRT_PACKET_RAYS] = {0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3};

/* Where the element of a lane lies in a block: columns of elements are `step` apart, and rows `row_step`. */
static inline size_t mlrt_lane_offset(uint32_t lane, size_t step, size_t row_step)
{
    return ((lane & 1) | (lane >> 1 & 2)) * step + ((lane >> 1 & 1) | (lane >> 2 & 2)) * row_step;
}

/* The lanes whose pixels lie in a block of width x height; neither is more than 4. */
static inline uint32_t mlrt_block_lanes(uint32_t width, uint32_t height)
{
    static const uint16_t columns[5] = {0, 0x0505, 0x0F0F, 0x5F5F, 0xFFFF};
    static const uint16_t rows[5] = {0, 0x0033, 0x00FF, 0x33FF, 0xFFFF};
    return columns[width] & rows[height];
}

#endif
