/* SPDX-License-Identifier: MIT */
/*
 * The nearest hits of a bundle's rays: bounds of tau, which planes are compared with, and of t.
 */
#ifndef MLRT_TRACE_NEAREST_HITS_H
#define MLRT_TRACE_NEAREST_HITS_H

#include <float.h>

#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/ray_hulls.h"

/* The nearest hits of a vector of rays: tau is between least_n / greatest_d and greatest_n / least_d. */
struct nearest_hits {
    vf least_n;
    vf greatest_n;
    vf least_d;
    vf greatest_d;
    vi triangle;
};

MLRT_INLINE void load_nearest_hits(const struct mlrt_bundle_rays *rays, const struct mlrt_packet *packet, int v,
                                   struct nearest_hits *nearest)
{
    nearest->least_n = v_load(rays->lo + v);
    nearest->greatest_n = v_load(rays->hi + v);
    nearest->least_d = nearest->greatest_d = v_set1(1);
    nearest->triangle = i_load(packet->nearest.triangle + v);
}

/*
 * Stores the nearest hits of a vector where they are not the packet's. The slack covers the two roundings of each
 * quotient (L8). Returns the lanes where they were stored.
 */
MLRT_INLINE uint32_t store_nearest_hits(const struct nearest_hits *nearest, int v, struct mlrt_bundle_rays *rays,
                                        struct mlrt_packet *packet)
{
    const vm same = i_eq(nearest->triangle, i_load(packet->nearest.triangle + v));
    const uint32_t changed = ~m_bits(same) & ALL_LANES;
    if (!changed) return 0;
    const vf lo = v_mul(v_div(nearest->least_n, nearest->greatest_d), v_set1(1 - RECIPROCAL_SLACK));
    const vf hi = v_mul(v_div(nearest->greatest_n, nearest->least_d), v_set1(1 + RECIPROCAL_SLACK));
    v_store(rays->lo + v, v_select(same, v_load(rays->lo + v), v_min(lo, v_set1(GREATEST_DISTANCE))));
    v_store(rays->hi + v, v_select(same, v_load(rays->hi + v), hi));
    i_store(packet->nearest.triangle + v, nearest->triangle);
    return changed << v;
}

/*
 * Bounds of t that are made from bounds of tau = t |d_main|, or the reverse, are moved apart by RECIPROCAL_SLACK of
 * themselves and by CONVERSION_FLOOR (L9): either of the two roundings may underflow and lose 2^-150. The floor is
 * needed. A ray may meet a slanted plane at a depth of less than 2^-149 from its origin; so it may meet two planes in
 * an order that t tells and tau does not.
 */
#define CONVERSION_FLOOR 0x1p-148f

/*
 * Sets the bounds of t in a packet from those of tau. Replaces -0 in its directions by 0, as 1 / -0 is -inf
 * (single_ray_boxes.h).
 */
static MLRT_NOINLINE void set_packet_distances(const struct mlrt_bundle_rays *rays, struct mlrt_packet *packet)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf pace = v_load(rays->pace + v), t_max = v_load(packet->t_max + v);
        const vm none = i_eq(i_load(packet->nearest.triangle + v), i_set1(MLRT_NONE));
        /* Where |d_main| is large, t may be denormal, and its least step is a large one in depth. */
        const vf floor = v_select(v_gt(pace, v_set1(MLRT_SAFE_MAX)), v_set1(0x1p-147f), v_set1(CONVERSION_FLOOR));
        const vf near = v_sub(v_mul(v_div(v_load(rays->lo + v), pace), v_set1(1 - RECIPROCAL_SLACK)), floor);
        const vf lo = v_max(v_min(near, v_set1(FLT_MAX)), v_set1(0));
        const vf hi = v_add(v_mul(v_div(v_load(rays->hi + v), pace), v_set1(1 + RECIPROCAL_SLACK)), floor);
        v_store(packet->nearest.lo + v, v_select(none, t_max, lo));
        v_store(packet->nearest.hi + v, v_select(none, t_max, hi));
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k)
            v_store(packet->direction[k] + v, v_add(v_load(packet->direction[k] + v), v_set1(0)));
    }
}

/* Sets the bounds of tau of a lane from those of t. */
MLRT_INLINE void set_lane_depths(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_bundle_rays *rays)
{
    const float lo = packet->nearest.lo[lane] * rays->pace[lane], hi = packet->nearest.hi[lane] * rays->pace[lane];
    const float near = lo * (1 - RECIPROCAL_SLACK) - CONVERSION_FLOOR;
    rays->lo[lane] = near < GREATEST_DISTANCE ? near : GREATEST_DISTANCE;
    rays->hi[lane] = hi * (1 + RECIPROCAL_SLACK) + CONVERSION_FLOOR;
}

/* Where a vector of rays meets the plane of a triangle: bounds of N and D, both negated where D < 0. */
struct plane_of_rays {
    vf least_n;
    vf greatest_n;
    vf least_d;
    vf greatest_d;
    vm backward; /* D < 0 */
    vm certain;  /* rays that may be inside the edges, and whose D has a certain sign */
    vm begun;    /* tau is surely greater than that of t_min */
};

/* Makes a triangle the nearest hit of the lanes `hit`. */
MLRT_INLINE void keep_plane(const struct plane_of_rays *plane, uint32_t number, vm hit, struct nearest_hits *nearest)
{
    nearest->least_n = v_select(hit, plane->least_n, nearest->least_n);
    nearest->greatest_n = v_select(hit, plane->greatest_n, nearest->greatest_n);
    nearest->least_d = v_select(hit, plane->least_d, nearest->least_d);
    nearest->greatest_d = v_select(hit, plane->greatest_d, nearest->greatest_d);
    nearest->triangle = i_select(hit, i_set1(number), nearest->triangle);
}

/*
 * Sets *farther to the rays that surely meet a plane behind their nearest hits, and *nearer to those that surely meet
 * it before. Both hold only where D has a certain sign. Quotients of bounds are compared as products (L8): rounding is
 * monotone, so if one rounded product is less than the other, so is the exact one.
 */
MLRT_INLINE void compare_planes(const struct plane_of_rays *plane, const struct nearest_hits *nearest, vm *farther,
                                vm *nearer)
{
    *farther = v_gt(v_mul(plane->least_n, nearest->least_d), v_mul(nearest->greatest_n, plane->greatest_d));
    *nearer = v_lt(v_mul(plane->greatest_n, nearest->greatest_d), v_mul(nearest->least_n, plane->least_d));
}

#endif
