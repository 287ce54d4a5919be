/* SPDX-License-Identifier: MIT */
/*
 * What a worker keeps about triangles for packets of one apex.
 */
#ifndef MLRT_MLRTA_SETUPS_H
#define MLRT_MLRTA_SETUPS_H

#include <stdint.h>

#include "base/platform.h"

/* Where something is seen from an apex, against a main axis: bounds of x_j / depth for the two other axes. */
struct mlrt_outline {
    float slope_lo[2];
    float slope_hi[2];
    float least_depth; /* along the main axis */
};

/*
 * What packets of one apex share about a triangle (triangle_setup.h): where it is seen from the apex, and the terms of
 * its edge functions.
 */
struct mlrt_triangle_setup {
    uint32_t number;    /* of the triangle; MLRT_NONE = empty entry */
    uint32_t main_axis; /* of the outline, with its sign: axis | negative << 2 */
    int has_terms;
    int in_plane; /* with terms: the apex lies in the triangle's plane, so no ray hits it at t > 0 */
    struct mlrt_outline outline;
    float distance;
    float distance_bound;
    MLRT_ALIGNED(16) float cross[3][4]; /* [component][edge ab, bc, ca; normal] */
};

#define MLRT_SETUP_COUNT 256 /* 24 KiB: fits the first-level cache beside a tile's packets and nodes */

#endif
