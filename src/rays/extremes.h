/* SPDX-License-Identifier: MIT */
/* The greater of two numbers; the least and the greatest of chosen lanes of sixteen, and of vectors lane by lane. */
#ifndef MLRT_RAYS_EXTREMES_H
#define MLRT_RAYS_EXTREMES_H

#include <math.h>

#include "rays/packet.h"
#include "simd/simd.h"

/* fmaxf but for NaNs, for which the compiler would have to call it. */
MLRT_INLINE float larger_of(float a, float b)
{
    return a > b ? a : b;
}

/* The least of the values of `lanes`; inf without lanes. */
MLRT_INLINE float lowest(const float *values, uint32_t lanes)
{
    vf all = v_set1(INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW)
        all = v_min(v_select(m_from_bits(lanes >> v), v_load(values + v), v_set1(INFINITY)), all);
    return v_hmin(all);
}

/* The greatest of the values of `lanes`; -inf without lanes. */
MLRT_INLINE float highest(const float *values, uint32_t lanes)
{
    vf all = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW)
        all = v_max(v_select(m_from_bits(lanes >> v), v_load(values + v), v_set1(-INFINITY)), all);
    return v_hmax(all);
}

/* Lane by lane, the least value so far, and the least negated value: minus the greatest. So v_min updates both. */
struct extremes {
    vf least;
    vf negated;
};

#define NO_EXTREMES ((struct extremes){v_set1(INFINITY), v_set1(INFINITY)})

MLRT_INLINE void add_to_extremes(vf a, struct extremes *of)
{
    of->least = v_min(a, of->least);
    of->negated = v_min(v_sub(v_set1(0), a), of->negated);
}

#endif
