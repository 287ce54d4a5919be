/* SPDX-License-Identifier: MIT */
/*
 * Outlines: where triangles and cells are seen from an apex. A packet skips a triangle or cell if its outline shows
 * that no ray can hit it.
 *
 * Along a main axis with its sign, a point in front of the apex has a depth, and over each of the two other axes a
 * slope x_j / depth. If all vertices of a triangle or box are in front of the apex, the slopes of every ray that hits
 * it lie between those of its vertices. The slope of a vertex has three roundings, that of a ray two; bounds of both
 * are moved apart by 2^-20 of themselves (SLOPE_SLACK). So rays whose slopes do not overlap an outline surely miss the
 * triangle or box. If a vertex is not in front of the apex, the outline has no bounds.
 *
 * Groups are narrow (ray_group.h), so none of their rays has a main component of 0.
 */
#ifndef MLRT_MLRTA_OUTLINE_H
#define MLRT_MLRTA_OUTLINE_H

#include <math.h>

#include "job/job.h"
#include "mlrta/setups.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"

/* A main axis and its sign as one number: axis | negative << 2. */
MLRT_INLINE uint32_t axis_code_of(int axis, int negative)
{
    return (uint32_t)axis | (negative ? 4u : 0);
}

MLRT_INLINE void set_outline_side(float lo, float hi, float least_depth, int side, struct mlrt_outline *outline)
{
    outline->slope_lo[side] = least_depth > 0 ? lo - fabsf(lo) * SLOPE_SLACK : -INFINITY;
    outline->slope_hi[side] = least_depth > 0 ? hi + fabsf(hi) * SLOPE_SLACK : INFINITY;
}

MLRT_INLINE void set_box_outline(const struct mlrt_box *box, uint32_t code, const float apex[3],
                                 struct mlrt_outline *outline)
{
    const uint32_t a = code & 3;
    const float near = code & 4 ? apex[a] - box->hi[a] : box->lo[a] - apex[a];
    const float far = code & 4 ? apex[a] - box->lo[a] : box->hi[a] - apex[a];
    outline->least_depth = near;
    for (int side = 0; side < 2; ++side) {
        const uint32_t j = (a + 1 + (uint32_t)side) % 3;
        const float lo = box->lo[j] - apex[j], hi = box->hi[j] - apex[j];
        set_outline_side(lo / (lo < 0 ? near : far), hi / (hi < 0 ? far : near), near, side, outline);
    }
}

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
