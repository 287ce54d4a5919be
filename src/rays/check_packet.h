/* SPDX-License-Identifier: MIT */
/*
 * Checks the rays of a packet, as they were read or made, a vector at a time. The answers are those of
 * mlrt_make_segment (exact/segment.h) and mlrt_is_safe_ray (source.h) for each ray.
 */
#ifndef MLRT_RAYS_CHECK_PACKET_H
#define MLRT_RAYS_CHECK_PACKET_H

#include <math.h>

#include "rays/source.h"
#include "simd/simd.h"

/*
 * 1 if all components of sixteen vectors surely are of magnitude 2^-60 .. 2^60, which is usual: a fast check of all
 * lanes at once. A NaN makes the sum a NaN, which fails the check.
 */
MLRT_INLINE int are_usual(float (*rows)[MLRT_PACKET_RAYS])
{
    vf least = v_set1(INFINITY), sum = v_set1(0);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf x = v_abs(v_load(rows[0] + v)), y = v_abs(v_load(rows[1] + v)), z = v_abs(v_load(rows[2] + v));
        least = v_min(v_min(v_min(x, y), z), least);
        sum = v_add(v_add(v_add(x, y), z), sum);
    }
    const vm small = v_le(sum, v_set1(MLRT_SAFE_MAX)), large = v_ge(least, v_set1(MLRT_SAFE_MIN));
    return MLRT_LIKELY(m_bits(m_and(small, large)) == ALL_LANES);
}

/*
 * The lanes whose vectors are finite, float-safe (0 or of magnitude 2^-60 .. 2^60), and not 0. A ray can hit a triangle
 * only if its origin and direction are finite and its direction is not 0.
 */
struct checked_lanes {
    uint32_t finite;
    uint32_t safe;
    uint32_t nonzero;
};

/* Checks the vectors of all lanes: together, and only if that fails, each of them. */
static MLRT_NOINLINE void check_lanes(float (*rows)[MLRT_PACKET_RAYS], struct checked_lanes *lanes)
{
    const vf zero = v_set1(0);
    *lanes = (struct checked_lanes){0xFFFF, 0xFFFF, 0xFFFF};
    if (are_usual(rows)) return;
    *lanes = (struct checked_lanes){0, 0, 0};
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vm is_safe = v_eq(zero, zero);
        vf greatest = zero, zero_or_nan = zero; /* NaNs are ignored; NaN where a component is not finite */
        for (int k = 0; k < 3; ++k) {
            const vf a = v_load(rows[k] + v), size = v_abs(a);
            is_safe = m_and(is_safe, m_or(v_eq(a, zero), v_ge(size, v_set1(MLRT_SAFE_MIN))));
            greatest = v_max(size, greatest);
            zero_or_nan = v_mul_add(a, zero, zero_or_nan);
        }
        lanes->finite |= m_bits(v_eq(zero_or_nan, zero)) << v;
        lanes->safe |= m_bits(m_and(is_safe, v_le(greatest, v_set1(MLRT_SAFE_MAX)))) << v;
        lanes->nonzero |= m_bits(v_gt(greatest, zero)) << v;
    }
}

/* Stores where rays begin and end, and that they have hit no triangle so far. */
MLRT_INLINE void take_limits(vf t_min, vf t_max, int v, struct mlrt_packet *packet)
{
    v_store(packet->t_min + v, t_min);
    v_store(packet->t_max + v, t_max);
    v_store(packet->nearest.lo + v, t_max);
    v_store(packet->nearest.hi + v, t_max);
    i_store(packet->nearest.triangle + v, i_set1(MLRT_NONE));
}

/* Sets `active` and `in_double` of `lanes` by rule R1 (exact/segment.h) and by which rays are float-safe (packet.h). */
MLRT_INLINE void check_vectors(uint32_t lanes, struct mlrt_packet *packet)
{
    struct checked_lanes origins = {0xFFFF, 0xFFFF, 0xFFFF}, directions; /* an apex is finite: source.c, camera.c */
    if (!packet->has.apex) {
        check_lanes(packet->origin, &origins);
    } else if (MLRT_UNLIKELY(!mlrt_are_float_safe(packet->apex))) {
        origins.safe = 0;
    }
    check_lanes(packet->direction, &directions);
    const uint32_t valid = lanes & origins.finite & directions.finite & directions.nonzero;
    packet->active = valid & origins.safe & directions.safe;
    packet->in_double = valid & ~packet->active;
}

/* Checks vectors and limits of `lanes`, those that exist. */
MLRT_INLINE void check_packet(uint32_t lanes, struct mlrt_packet *packet)
{
    uint32_t is_interval = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        for (int k = 0; k < 3; ++k) { /* -0 becomes 0 */
            v_store(packet->direction[k] + v, v_add(v_load(packet->direction[k] + v), v_set1(0)));
        }
        const vf given = v_load(packet->t_min + v), t_max = v_load(packet->t_max + v);
        const vf t_min = v_select(v_lt(given, v_set1(0)), v_set1(0), given);
        take_limits(t_min, t_max, v, packet);
        is_interval |= m_bits(v_lt(t_min, t_max)) << v;
    }
    check_vectors(lanes & is_interval, packet);
}

/* Leaves active rays whose origins have a coordinate beyond `reach` to double. */
MLRT_INLINE void set_far_rays_aside(float reach, struct mlrt_packet *packet)
{
    uint32_t within = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf greatest = v_set1(0);
        for (int k = 0; k < 3; ++k) {
            const vf origin = packet->has.apex ? v_set1(packet->apex[k]) : v_load(packet->origin[k] + v);
            greatest = v_max(v_abs(origin), greatest);
        }
        within |= m_bits(v_le(greatest, v_set1(reach))) << v;
    }
    packet->in_double |= packet->active & ~within;
    packet->active &= within;
}

#endif
