/* SPDX-License-Identifier: MIT */
/*
 * The least and the greatest: of two numbers, of some lanes of sixteen, and of what comes along. And how far bounds of
 * quotients are moved apart, as shares of themselves, to be safe from rounding: those of reciprocals
 * (interval_traversal.h, trace/single.h) and of slopes (mlrta/outline.h, trace/hulls.h).
 */
#ifndef MLRT_RAYS_EXTREMES_H
#define MLRT_RAYS_EXTREMES_H

#include <math.h>

#include "rays/packet.h"
#include "simd/simd.h"

#define RECIPROCAL_SLACK 0x1p-21f

/* fmaxf without its care for NaNs, which is a call. */
MLRT_INLINE float larger_of(float a, float b)
{
    return a > b ? a : b;
}

MLRT_INLINE float lowest(const float *values, uint32_t lanes)
{
    vf all = v_set1(INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        all = v_min(v_select(m_from_bits(lanes >> v), v_load(values + v), v_set1(INFINITY)), all);
    }
    return v_hmin(all);
}

MLRT_INLINE float highest(const float *values, uint32_t lanes)
{
    vf all = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        all = v_max(v_select(m_from_bits(lanes >> v), v_load(values + v), v_set1(-INFINITY)), all);
    }
    return v_hmax(all);
}

/* Lane by lane, the least and the greatest so far: that one negated, so that the least counts of both. */
struct extremes {
    vf least;
    vf negated;
};

#define NO_EXTREMES ((struct extremes){v_set1(INFINITY), v_set1(INFINITY)})

#endif
