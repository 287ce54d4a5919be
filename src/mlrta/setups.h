/* SPDX-License-Identifier: MIT */
/* Set-ups of triangles, which a worker keeps for packets from one apex. */
#ifndef MLRT_MLRTA_SETUPS_H
#define MLRT_MLRTA_SETUPS_H

#include <stdint.h>

#include "base/platform.h"

/* Where a triangle or box is seen from an apex (outline.h): bounds of x_j / depth over the two axes beside the main. */
struct mlrt_outline {
    float slope_lo[2];
    float slope_hi[2];
    float least_depth; /* along the main axis */
};

/* What packets from one apex share about a triangle: its outline, and the terms of its edge functions. */
struct mlrt_triangle_setup {
    uint32_t number;    /* of the triangle; MLRT_NONE = empty entry */
    uint32_t axis_code; /* of the outline (outline.h) */
    int has_terms;      /* in_plane, distance, distance_bound and cross are set. Method packet2 sets no outline */
    int in_plane;       /* the apex lies in the triangle's plane, so no ray hits it at t > 0 */
    struct mlrt_outline outline;
    float distance;
    float distance_bound;
    MLRT_ALIGNED(16) float cross[3][4]; /* [component][edge ab, bc, ca; normal] */
};

#define MLRT_SETUP_COUNT 256 /* 24 KiB: fits the first-level cache beside a tile's packets and nodes */

/* The table of a worker. */
struct mlrt_setups {
    float apex[3];                        /* the origin of the rays that it is for */
    uint32_t mask;                        /* length, a power of two, less one */
    struct mlrt_triangle_setup entries[]; /* that of a triangle is entry number & mask */
};

#endif
