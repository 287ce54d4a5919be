/* SPDX-License-Identifier: MIT */
/*
 * Outlines of triangles, and the rays of a packet whose slopes overlap an outline. cell_outline.h says what an outline
 * is.
 *
 * Groups are narrow (ray_group.h), so none of their rays has a main component of 0.
 */
#ifndef MLRT_MLRTA_OUTLINE_H
#define MLRT_MLRTA_OUTLINE_H

#include <math.h>

#include "job/job.h"
#include "mlrta/cell_outline.h"
#include "mlrta/setups.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"

MLRT_INLINE void set_triangle_outline(const struct mlrt_triangle *triangle, uint32_t code, const float apex[3],
                                      struct mlrt_outline *outline)
{
    const uint32_t a = code & 3;
    f4 corner[3];
    f4_corners(triangle->v, corner);
    const f4 depth = f4_flip(f4_sub(corner[a], f4_set1(apex[a])), code & 4 ? -1.0f : 1.0f);
    const float least = outline->least_depth = f4_hmin(depth);
    for (int side = 0; side < 2; ++side) {
        const uint32_t j = (a + 1 + (uint32_t)side) % 3;
        const f4 slope = f4_div(f4_sub(corner[j], f4_set1(apex[j])), depth);
        set_outline_side(f4_hmin(slope), f4_hmax(slope), least, side, outline);
    }
}

/* Bounds of d_j / |d_main| for each ray of a packet, moved apart by SLOPE_SLACK. */
struct ray_slopes {
    MLRT_ALIGNED(64) float lo[2][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float hi[2][MLRT_PACKET_RAYS];
};

MLRT_INLINE uint32_t overlapping_lanes(const struct ray_slopes *slopes, const struct mlrt_outline *outline)
{
    uint32_t lanes = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm wide = m_and(v_le(v_load(slopes->lo[0] + v), v_set1(outline->slope_hi[0])),
                              v_ge(v_load(slopes->hi[0] + v), v_set1(outline->slope_lo[0])));
        const vm high = m_and(v_le(v_load(slopes->lo[1] + v), v_set1(outline->slope_hi[1])),
                              v_ge(v_load(slopes->hi[1] + v), v_set1(outline->slope_lo[1])));
        lanes |= m_bits(m_and(wide, high)) << v;
    }
    return lanes;
}

#endif
