/* SPDX-License-Identifier: MIT */
/*
 * The slopes of cells whose rays start at the waist, four cells at a time, from points on the rays at their corners.
 */
#ifndef MLRT_TRACE_CORNER_SLOPES_H
#define MLRT_TRACE_CORNER_SLOPES_H

#include <math.h>

#include "rays/slope_limits.h"
#include "simd/quad.h"
#include "trace/bundle.h"

/* Of four cells, the extremes over their corners. */
struct corner_slopes {
    f4 least_depth;
    f4 greatest_depth;
    f4 lo[2]; /* slopes */
    f4 hi[2];
};

#define NO_CORNERS                                                                                                     \
    ((struct corner_slopes){f4_set1(INFINITY),                                                                         \
                            f4_set1(-INFINITY),                                                                        \
                            {f4_set1(INFINITY), f4_set1(INFINITY)},                                                    \
                            {f4_set1(-INFINITY), f4_set1(-INFINITY)}})

/*
 * Extends `of` by one corner of each cell. `point` is relative to the waist: its main component, which has the sign of
 * the waist, and the two that follow.
 */
MLRT_INLINE void add_corner(float sign, const f4 point[3], struct corner_slopes *of)
{
    const f4 depth = f4_flip(point[0], sign), inverse = f4_div(f4_set1(1), depth);
    of->least_depth = f4_min(depth, of->least_depth);
    of->greatest_depth = f4_max(depth, of->greatest_depth);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        const f4 slope = f4_mul(point[1 + i], inverse);
        of->lo[i] = f4_min(slope, of->lo[i]);
        of->hi[i] = f4_max(slope, of->hi[i]);
    }
}

/*
 * Sets the slopes of four cells. A ray may be off the rectangle between the corners by `error`, in the same components.
 * If its depth there, z, is more than 4 errors, its slope exceeds the extremes by at most
 * 2 (error_j + |slope| error_main) / z. Returns the cells of which that is true and whose slopes are not too steep.
 *
 * Slopes may be denormal, where SLOPE_SLACK vanishes and a rounding is a large part of the slope: so all slopes are
 * moved by SLOPE_FLOOR too. (Those of packets that have rays are 0 or at least LEAST_SLOPE.)
 */
MLRT_INLINE uint32_t set_cell_slopes(const struct corner_slopes *of, const f4 error[3], uint32_t first,
                                     struct mlrt_hulls *hulls)
{
    const f4 inverse = f4_div(f4_set1(2), of->least_depth);
    uint32_t fit = f4_above(of->least_depth, f4_mul(f4_set1(4), error[0]));
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        const f4 steepest = f4_max(f4_abs(of->lo[i]), f4_abs(of->hi[i]));
        const f4 room = f4_mul(f4_add(error[1 + i], f4_mul(steepest, error[0])), inverse);
        const f4 slack = f4_add(f4_add(room, f4_mul(steepest, f4_set1(SLOPE_SLACK))), f4_set1(SLOPE_FLOOR));
        f4_store(hulls->term[MLRT_SLOPE_J + i].lo + first, f4_sub(of->lo[i], slack));
        f4_store(hulls->term[MLRT_SLOPE_J + i].hi + first, f4_add(of->hi[i], slack));
        fit &= f4_above(f4_set1(STEEPEST_SLOPE), steepest);
    }
    return fit;
}

#endif
