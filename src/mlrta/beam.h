/* SPDX-License-Identifier: MIT */
/*
 * A beam: a conservative hull of a group of rays whose directions have the same signs.
 *
 * For every ray o + t d of the group and every pair of axes a != j:
 *
 *   - origin_lo <= o <= origin_hi on each axis;
 *   - d_a >= 0, or d_a < 0 where negative[a];
 *   - slope_lo[a][j] <= d_j / d_a <= slope_hi[a][j], infinite where a ray has d_a = 0. Each bound is moved outward by
 *     2^-20 of itself, which covers every rounding in the tests of beam_culling.h;
 *   - every point where a hit can still decide the ray's result lies in `region`.
 *
 * Based on: Reshetov et al. 2005, section 4.1, requirement (3): a rectangle on any axis-aligned plane, and common
 * signs.
 */
#ifndef MLRT_MLRTA_BEAM_H
#define MLRT_MLRTA_BEAM_H

#include "exact/triangle.h"
#include "mlrt.h"

struct mlrt_beam {
    float origin_lo[3];
    float origin_hi[3];
    float slope_lo[3][3];
    float slope_hi[3][3];
    struct mlrt_box region;
    int negative[3];
    int main_axis;    /* the axis of the largest |d|, as an estimate */
    int has_apex;     /* all rays have the same origin */
    int may_cover;    /* every ray can hit every triangle at any t > 0: no skip, no mask, t_min = 0 */
    int is_unlimited; /* all rays are valid and have no t_max; 0 for rays of arrays */
};

struct mlrt_source;

/*
 * Makes the beam of a tile of a source. Returns 0 if it has none: the directions of its rays differ in sign, or may
 * be 0 along all axes, a ray is not float-safe (rays/source.h), or no ray is valid.
 */
int mlrt_get_beam(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                  struct mlrt_beam *beam);

/* Sets the bounds of d_j / d_a from lo <= d_j / d_a <= hi. If lo or hi is a NaN, the slope has no bounds. */
void mlrt_set_slope(struct mlrt_beam *beam, int a, int j, double lo, double hi);

#endif
