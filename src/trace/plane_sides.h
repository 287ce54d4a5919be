/* SPDX-License-Identifier: MIT */
/*
 * On which side of a triangle's plane the rays of a packet begin or end (L15). Rays begin on surfaces, and end on them.
 *
 * If D has one certain sign, say +1, a ray does not hit the triangle if N < 0, as then t < 0, or if N > t_max D. Both
 * are decided in double, with the determinants and sizes of close_calls.h. N - t_max D has no more than 9 roundings: 8
 * of N, or 7 of D and 1 of the product, and 1 of the difference. So it is off by 9.001 * 2^-53 of s(N) + t_max s(D), of
 * which CLOSE_ERROR is 12. If t_max is infinite, the latter is not decided: no comparison is true.
 */
#ifndef MLRT_TRACE_PLANE_SIDES_H
#define MLRT_TRACE_PLANE_SIDES_H

#include "hits/close_calls.h"

/* N - t D of a plane, given N. */
MLRT_INLINE struct measured_lanes measure_end(const struct mlrt_plane *plane, const struct mlrt_packet *packet,
                                              const float *t, uint32_t lane, const struct measured_lanes *n)
{
    const struct measured_lanes d = measure_d(plane, packet, lane);
    const vd end = d_load(t + lane);
    return (struct measured_lanes){d_sub(n->value, d_mul(end, d.value)), d_mul_add(end, d.size, n->size)};
}

/* On which side of a plane the rays of a packet are, each at a t of its own. */
struct sides_of_plane {
    uint32_t before; /* rays that surely do not reach it by then: N / D > t */
    uint32_t behind; /* rays that are surely past it: N / D < t */
};

/* Finds the sides of a plane by the sign of N - t D in double. `sign` is that of D. With t NULL, t is 0. */
MLRT_INLINE struct sides_of_plane find_sides_of_plane(const struct mlrt_plane *plane, const struct mlrt_packet *packet,
                                                      const float *t, double sign)
{
    const vd error = d_set1(CLOSE_ERROR), signs = d_set1(sign);
    struct sides_of_plane sides = {0, 0};
    vd to_a[3];
    struct measured_lanes n = measure_n(plane, packet, 0, to_a);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        if (!packet->has.apex) n = measure_n(plane, packet, lane, to_a);
        const struct measured_lanes height = t ? measure_end(plane, packet, t, lane, &n) : n;
        const vd value = d_flip(height.value, signs), bound = d_mul(height.size, error);
        sides.before |= d_gt(value, bound) << lane;
        sides.behind |= d_gt(d_sub(d_set1(0), value), bound) << lane;
    }
    return sides;
}

#endif
