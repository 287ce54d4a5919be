/* SPDX-License-Identifier: MIT */
/*
 * A beam: a conservative hull of a group of rays that agree in the signs of their directions.
 *
 * For every ray o + t d of the group and every pair of axes a != j:
 *   origin_lo <= o <= origin_hi;  d_a >= 0, or d_a < 0 where negative[a];
 *   slope_lo[a][j] <= d_j / d_a <= slope_hi[a][j], with room to spare: each bound is moved outward by 2^-20 of itself,
 *   which pays for every rounding in the tests of beam_culling.h (a ray with d_a = 0 has infinite slopes);
 *   and every point of the ray that matters lies in `region`.
 *
 * Based on: Reshetov et al. 2005, section 4.1, requirement (3): a rectangle on any axis-aligned plane, and common
 * signs.
 */
#ifndef MLRT_MLRTA_BEAM_H
#define MLRT_MLRTA_BEAM_H

#include "exact/triangle.h"

struct mlrt_beam {
    float origin_lo[3];
    float origin_hi[3];
    float slope_lo[3][3];
    float slope_hi[3][3];
    struct mlrt_box region;
    int negative[3];
    int main_axis;    /* where |d| is largest, about */
    int has_apex;     /* one common origin */
    int may_cover;    /* every ray counts every triangle from its origin on: no skip, no mask, t_min = 0 */
    int is_unlimited; /* all rays are valid and have no t_max */
};

#define MLRT_SLOPE_SLACK 0x1p-20

struct mlrt_source;
struct mlrt_view;

/* The beam of a tile of a source; 0 if its rays differ in sign, are not float-safe, or are all invalid. */
int mlrt_get_beam(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                  struct mlrt_beam *beam);

/* Bounds lo <= d_j / d_a <= hi into a beam. NaNs become no bound. */
void mlrt_set_slope(struct mlrt_beam *beam, int a, int j, double lo, double hi);

/* The beam of a tile, or 0 if its rays differ in sign or are beyond what beams can hold. */
int mlrt_make_view_beam(const struct mlrt_view *view, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                        struct mlrt_beam *beam);

#endif
