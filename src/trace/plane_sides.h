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
#include "simd/doubles.h"
#include "trace/planes.h"

/* A number of DW lanes, and the size that its error is relative to. */
struct measured_lanes {
    vd value;
    vd size;
};

/* Sets N of a plane. */
MLRT_INLINE void measure_n(const struct mlrt_plane *plane, const struct mlrt_packet *packet, uint32_t lane,
                           struct measured_lanes *n)
{
    n->value = n->size = d_set1(0);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vd to = d_sub(d_set1(plane->point[k]), origins_in_double(packet, k, lane));
        n->value = d_mul_add(to, d_set1(plane->normal[k]), n->value);
        n->size = d_mul_add(d_abs(to), d_set1(plane->size[k]), n->size);
    }
}

/* Sets N - t D of a plane. */
MLRT_INLINE void measure_end(const struct mlrt_plane *plane, const struct mlrt_packet *packet, const float *t,
                             uint32_t lane, const struct measured_lanes *n, struct measured_lanes *height)
{
    const vd end = d_load(t + lane);
    vd d = d_set1(0), d_size = d;
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vd direction = d_load(packet->direction[k] + lane);
        d = d_mul_add(direction, d_set1(plane->normal[k]), d);
        d_size = d_mul_add(d_abs(direction), d_set1(plane->size[k]), d_size);
    }
    height->value = d_sub(n->value, d_mul(end, d));
    height->size = d_mul_add(end, d_size, n->size);
}

/* On which side of a plane the rays of a packet are, each at a t of its own. */
struct sides_of_plane {
    uint32_t before; /* rays that surely do not reach it by then: N / D > t */
    uint32_t behind; /* rays that are surely past it: N / D < t */
};

/*
 * Finds the sides of a plane by the sign of N - t D in double. `sign` is that of D. With t NULL, t is 0. If the packet
 * has an apex, *of_apex must be N of the apex.
 */
MLRT_INLINE struct sides_of_plane find_sides_of_plane(const struct mlrt_plane *plane, const struct mlrt_packet *packet,
                                                      const float *t, double sign, const struct measured_lanes *of_apex)
{
    const vd error = d_set1(CLOSE_ERROR), signs = d_set1(sign);
    struct sides_of_plane sides = {0, 0};
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        struct measured_lanes n = *of_apex;
        if (!packet->has.apex) measure_n(plane, packet, lane, &n);
        struct measured_lanes height = n;
        if (t) measure_end(plane, packet, t, lane, &n, &height);
        const vd value = d_flip(height.value, signs), bound = d_mul(height.size, error);
        sides.before |= d_gt(value, bound) << lane;
        sides.behind |= d_gt(d_sub(d_set1(0), value), bound) << lane;
    }
    return sides;
}

#endif
