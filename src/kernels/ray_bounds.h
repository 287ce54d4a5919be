/* SPDX-License-Identifier: MIT */
/*
 * Bounds of the directions of some rays of one apex, and the cell (cells.h) that they make. For the kernels and for who
 * makes cells for them: in the words of the quad_*.h that was included before.
 */
#ifndef MLRT_RAY_BOUNDS_H
#define MLRT_RAY_BOUNDS_H

#include "kernels/slopes.h"
#include "tile.h"

/* A packet whose slopes differ by more than this gains nothing from going through the tree as one. */
#define WIDEST_PACKET 0.25f

/* The slopes of a cell from the least over both axes and the greatest, negated, and what rounding may move them by
 * besides; 0 if they are steep or wide. */
MLRT_INLINE int mlrt_set_packet_slopes(struct mlrt_cells *cells, uint32_t place, f4 all, float slack)
{
    MLRT_ALIGNED(16) float least[4];
    const f4 moved = f4_sub(f4_sub(all, f4_mul(f4_abs(all), f4_set1(SLOPE_SLACK))), f4_set1(slack));
    const f4 width = f4_add(f4_low(all, all), f4_high(all, all)); /* negated, twice each */
    const f4 is_steep = f4_add(all, f4_set1(STEEPEST_SLOPE)), is_wide = f4_add(width, f4_set1(WIDEST_PACKET));
    if (f4_signs(is_steep) | f4_signs(is_wide)) return 0;
    f4_store(least, moved);
    for (int side = 0; side < 2; ++side) mlrt_set_cell_slopes(cells, place, side, least[side], -least[2 + side]);
    return 1;
}

/* Makes a cell of rays that all end at `t_max`; 0 if they do not agree with the main axis, or are wide. */
MLRT_INLINE int mlrt_set_cell(struct mlrt_cells *cells, uint32_t place, const struct mlrt_ray_bounds *bounds,
                              float t_max)
{
    if (!(bounds->depth[0] > 0) || !mlrt_set_packet_slopes(cells, place, f4_load(bounds->slopes), 0)) return 0;
    cells->farthest[place] = t_max * -bounds->depth[1] * (1 + SLOPE_SLACK);
    cells->shortest[place] = t_max * bounds->depth[0] * (1 - SLOPE_SLACK);
    return 1;
}

#endif
