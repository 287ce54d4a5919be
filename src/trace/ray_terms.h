/* SPDX-License-Identifier: MIT */
/*
 * The terms of a bundle's rays (bundle.h), for rays that a packet has as their source gave them. L2, L3, ... are the
 * lemmas of docs/accuracy.md, "Bundles", which derive the bounds.
 *
 * RAYS, u = 2^-24. The origin o relative to the waist, with the sign of the main axis, has 1 rounding per component. A
 * slope s_j = d_j / |d_main| has 1 in lanes, and 2 in hulls, which multiply by a reciprocal (L2). For the rays of a
 * packet, let R be at least 1 and 2 |s_j|, A at least |o_main|, 2 |o_j| and 2 |o_l|, and X at least |x_j| and |x_l|.
 * By L3 an intercept x_j = o_j - s_j o_main is off by no more than
 *
 *     E = 3.05 u R A + 2^-149,    in hulls 3.55 u R A + 2^-149.
 *
 * A ray from the waist has o = 0, and so the intercept 0 exactly.
 *
 * UNDERFLOW. A slope is 0 or at least LEAST_SLOPE, except where all slopes of a packet underflow to 0, and so lose at
 * most 2^-150. The product s_j o_main may lose 2^-150, and so may the product of a slope and a depth.
 */
#ifndef MLRT_TRACE_RAY_TERMS_H
#define MLRT_TRACE_RAY_TERMS_H

#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/ray_tile.h"

/* Component k of the origins of a vector of lanes. */
MLRT_INLINE vf origin_component(const struct mlrt_packet *packet, int k, int v)
{
    return packet->has.apex ? v_set1(packet->apex[k]) : v_load(packet->origin[k] + v);
}

/* A vector of rays of a packet: the numbers from which slopes and intercepts are made. */
struct given_rays {
    vf pace;          /* |d_main|, not in units */
    vf across[2];     /* d_j, d_l, not in units */
    vf from_waist[3]; /* o: depth, j, l */
};

MLRT_INLINE void load_given_rays(const struct mlrt_bundle *bundle, const struct mlrt_packet *packet, int has_intercepts,
                                 int v, struct given_rays *rays)
{
    const int a = bundle->waist.main_axis, axis[3] = {a, mlrt_slope_axis(a, 0), mlrt_slope_axis(a, 1)};
    const vf sign = v_set1(bundle->waist.sign), unit = v_set1(bundle->scene.unit);
    rays->pace = v_flip(v_load(packet->direction[a] + v), sign);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) rays->across[i] = v_load(packet->direction[axis[1 + i]] + v);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        rays->from_waist[k] = v_set1(0);
        if (!has_intercepts) continue;
        const vf w = v_set1(bundle->waist.point[axis[k]]);
        const vf away = v_mul_sub(origin_component(packet, axis[k], v), unit, w); /* the product is exact */
        rays->from_waist[k] = k == 0 ? v_flip(away, sign) : away;
    }
}

/* The rays whose origins are exact in units. */
MLRT_INLINE vm exact_in_units(const struct mlrt_bundle *bundle, const struct mlrt_packet *packet, int v)
{
    vm exact = m_from_bits(ALL_LANES);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vf given = origin_component(packet, k, v), origin = v_mul(given, v_set1(bundle->scene.unit));
        exact = m_and(exact, v_eq(v_mul(origin, v_set1(1 / bundle->scene.unit)), given));
    }
    return exact;
}

/* Has a packet active rays with slopes that are smaller than LEAST_SLOPE, but not 0? */
static MLRT_NOINLINE int has_tiny_slopes(const struct mlrt_bundle *bundle, const struct mlrt_packet *packet)
{
    uint32_t tiny = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        struct given_rays rays;
        load_given_rays(bundle, packet, 0, v, &rays);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const vf slope = v_abs(v_div(rays.across[i], rays.pace));
            const vm is_zero = v_eq(rays.across[i], v_set1(0)), is_usual = v_ge(slope, v_set1(LEAST_SLOPE));
            tiny |= (~m_bits(m_or(is_zero, is_usual)) & ALL_LANES) << v;
        }
    }
    return (tiny & packet->active) != 0;
}

/* Lower ends of distances are at most this, so that they are finite and can be multiplied. */
#define GREATEST_DISTANCE 0x1p126f

/* Computes the numbers of a packet's rays, which have no hits so far. */
static MLRT_NOINLINE void make_lanes(struct mlrt_bundle *bundle, uint32_t place)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const vf zero = v_set1(0), unit = v_set1(bundle->scene.unit);
    bundle->state.has_lanes |= 1u << place;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        struct given_rays given;
        vf slope[2], at[2], to_waist[3];
        load_given_rays(bundle, packet, bundle->has.intercepts, v, &given);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            slope[i] = v_div(given.across[i], given.pace);
            v_store(rays->term[MLRT_SLOPE_J + i] + v, slope[i]);
        }
        v_store(rays->to_waist[0] + v, zero);
        if (bundle->has.intercepts) {
            MLRT_UNROLL
            for (int k = 0; k < 3; ++k) {
                to_waist[k] = v_sub(zero, given.from_waist[k]);
                v_store(rays->to_waist[k] + v, to_waist[k]);
            }
            MLRT_UNROLL
            for (int i = 0; i < 2; ++i) {
                at[i] = v_mul_sub(slope[i], to_waist[0], to_waist[1 + i]);
                v_store(rays->term[MLRT_INTERCEPT_J + i] + v, at[i]);
            }
            v_store(rays->term[MLRT_MOMENT] + v, v_mul_sub(slope[1], at[0], v_mul(slope[0], at[1])));
        }
        const vf pace = v_mul(given.pace, unit), end = v_mul(v_load(packet->t_max + v), pace);
        const vf t_min = packet->has.limits ? v_max(v_load(packet->t_min + v), zero) : zero;
        v_store(rays->pace + v, pace);
        v_store(rays->begin + v, v_mul(t_min, pace));
        v_store(rays->lo + v, v_min(v_mul(end, v_set1(1 - SLOPE_SLACK)), v_set1(GREATEST_DISTANCE)));
        v_store(rays->hi + v, v_mul(end, v_set1(1 + SLOPE_SLACK)));
        v_store(packet->t_min + v, t_min);
        i_store(packet->nearest.triangle + v, i_set1(MLRT_NONE));
    }
}

/* Computes the numbers of a packet's rays unless this was done before. */
MLRT_INLINE void need_lanes(struct mlrt_bundle *bundle, uint32_t place)
{
    if (!(bundle->state.has_lanes >> place & 1)) make_lanes(bundle, place);
}

#endif
