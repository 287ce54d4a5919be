/* SPDX-License-Identifier: MIT */
/*
 * A hull of the lanes of a packet that go lane by lane, and the boxes that it meets: those of a node, and those of the
 * triangles of a leaf. What it misses is not tested against the lanes.
 *
 * Along an axis where the signs of all directions agree, the hull is the intervals of origins and of reciprocals: the
 * product of a difference and a reciprocal lies between those of the intervals' ends, and roundings are monotone. Along
 * another axis, the hull is the interval of all coordinates on the rays, from o to e = o + t d for the t where they
 * end, or everything if they do not end. As computed, t d is off by 1.001 u of itself, so of |o| + |e|, and the sum by
 * u |e|. So e is moved outward by 4 u (|o| + |e|). This also covers the rounding of the moved end, u of itself.
 * Underflow needs no room: let a ray reach a plane at c, so that c - o <= t d. If |t d| < 2^-125, then c - o, a
 * multiple of 2^-149, is a float or less than all products that are as small. Roundings are monotone: c - o is at most
 * t d as computed, and so c at most e. If e is infinite, the sum or the difference is a NaN, which v_min and v_max
 * drop: then o is the end, which is right.
 */
#ifndef MLRT_TRACE_LANES_HULL_H
#define MLRT_TRACE_LANES_HULL_H

#include <float.h>
#include <math.h>

#include "rays/extremes.h"
#include "rays/packet.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/single_ray_boxes.h"

/* Bounds of the rays of a packet, along each axis and of t. */
struct lanes_hull {
    int agree[3];       /* all d_k have one sign, and none is 0 */
    float lo[3], hi[3]; /* of origins where signs agree, else of all coordinates on the rays */
    float reciprocal_lo[3], reciprocal_hi[3];
    float direction_lo[3], direction_hi[3];
    int is_narrow; /* rays end, or signs agree along two axes or more: else hardly a box misses the hull */
    float least_t_min;
    float farthest; /* the greatest t where a ray ends, before any hit */
};

/* Sets lo and hi of the hull along axis k to the interval of all coordinates on the rays: see above. */
MLRT_INLINE void bound_along(const struct mlrt_packet *packet, uint32_t lanes, int k, struct lanes_hull *hull)
{
    vf lo = v_set1(INFINITY), hi = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm among = m_from_bits(lanes >> v);
        const vf origin = v_load(packet->origin[k] + v), d = v_load(packet->direction[k] + v);
        const vf end = v_add(origin, v_mul(v_min(v_load(packet->nearest.hi + v), v_set1(FLT_MAX)), d));
        const vf slack = v_mul(v_add(v_abs(origin), v_abs(end)), v_set1(0x1p-22f));
        lo = v_min(v_select(among, v_min(v_sub(end, slack), origin), v_set1(INFINITY)), lo);
        hi = v_max(v_select(among, v_max(v_add(end, slack), origin), v_set1(-INFINITY)), hi);
    }
    hull->lo[k] = v_hmin(lo);
    hull->hi[k] = v_hmax(hi);
}

/*
 * Sets the hull along axis k, where directions lie between `from` and `to`, and `lo` and `hi` are those of origins.
 * Where signs agree, reciprocals and roundings are monotone: so the ends of the hull are those of a lane.
 */
MLRT_INLINE void set_hull_along(const struct mlrt_packet *packet, uint32_t lanes, int k, float from, float to,
                                struct lanes_hull *hull)
{
    hull->direction_lo[k] = from;
    hull->direction_hi[k] = to;
    hull->agree[k] = from > 0 || to < 0;
    if (hull->agree[k]) {
        hull->reciprocal_lo[k] = 1 / from * (from > 0 ? -RECIPROCAL_SLACK - 1 : RECIPROCAL_SLACK - 1);
        hull->reciprocal_hi[k] = 1 / to * (from > 0 ? RECIPROCAL_SLACK - 1 : -RECIPROCAL_SLACK - 1);
    } else if (hull->farthest < FLT_MAX) {
        bound_along(packet, lanes, k, hull);
    } else {
        hull->lo[k] = -INFINITY;
        hull->hi[k] = INFINITY;
    }
}

/* No ray of `lanes` needs a hit behind this t: that of its nearest hit so far or, if any will do, of its end. */
MLRT_INLINE float last_end(const struct lanes_hull *hull, const struct mlrt_packet *packet, uint32_t lanes, int any)
{
    return any ? hull->farthest : finite_limit(highest(packet->nearest.hi, lanes));
}

/* A vector of boxes on their way through the axes. */
struct boxes_in_hull {
    vf first, last; /* t between which rays are in them */
    vm missed;      /* by the intervals of coordinates */
};

/* Rays end at t = `farthest` at the latest. */
MLRT_INLINE void begin_boxes(const struct lanes_hull *hull, float farthest, struct boxes_in_hull *boxes)
{
    boxes->first = v_set1(hull->least_t_min);
    boxes->last = v_set1(farthest);
    boxes->missed = m_from_bits(0);
}

/* Compares boxes that go from lo to hi along axis k with the hull. A NaN leaves nothing out. */
MLRT_INLINE void cut_boxes(const struct lanes_hull *hull, int k, vf lo, vf hi, struct boxes_in_hull *boxes)
{
    const vf from = v_set1(hull->lo[k]), to = v_set1(hull->hi[k]);
    if (!hull->agree[k]) {
        boxes->missed = m_or(boxes->missed, m_or(v_gt(lo, to), v_lt(hi, from)));
        return;
    }
    const int down = hull->direction_hi[k] < 0;
    const vf x = v_sub(to, lo), y = v_sub(from, hi), near = down ? y : x, far = down ? x : y;
    const vf least = v_set1(hull->reciprocal_lo[k]), greatest = v_set1(hull->reciprocal_hi[k]);
    boxes->first = v_max(v_min(v_mul(near, least), v_mul(near, greatest)), boxes->first);
    boxes->last = v_min(v_max(v_mul(far, least), v_mul(far, greatest)), boxes->last);
}

/* The boxes that the hull misses. */
MLRT_INLINE vm boxes_missed(const struct boxes_in_hull *boxes)
{
    return m_or(boxes->missed, v_gt(boxes->first, boxes->last));
}

#endif
