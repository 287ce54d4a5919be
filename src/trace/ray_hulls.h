/* SPDX-License-Identifier: MIT */
/*
 * The hulls of the packets of a bundle. L2, L3, ... are the lemmas of docs/accuracy.md, "Bundles", which derive the
 * bounds; u, R, A and X are as in ray_terms.h.
 *
 * A hull is made in steps: bound_rays finds the extremes of a packet's rays, hulls_fit sets A and tells which packets
 * float carries, finish_depths and finish_hulls move the extremes apart. bound_packet finds the extremes again, when
 * fewer rays are active.
 *
 * HULLS (L10) are made from rays as they were read, and contain their exact slopes, and their exact intercepts but for
 * INTERCEPT_ERROR R A, which is 4 u R A, for the errors of intercepts in hulls and in lanes. The radius of a term is
 * half its range, made larger by 2^-20 of itself and by 2^-21 of the middle. This covers the 2.001 u of a slope, and
 * the roundings of middle and radius. The interval of the moment is made from those of its factors (product_over_hull),
 * and A from depths, slopes and intercepts (hulls_fit).
 *
 * UNDERFLOW. Where R A is below 2^-128, INTERCEPT_ERROR R A is less than what the products of ray_terms.h may lose.
 * INTERCEPT_FLOOR covers it. It is not denormal: some processors take 60 ns to multiply by a denormal.
 *
 * DEPTHS (L13) at which rays begin and end, o_main + tau, are moved apart by SLOPE_SLACK (|z| + A).
 */
#ifndef MLRT_TRACE_RAY_HULLS_H
#define MLRT_TRACE_RAY_HULLS_H

#include <float.h>
#include <math.h>

#include "bvh/unit.h"
#include "rays/extremes.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/ray_terms.h"
#include "trace/ray_tile.h"

#define INTERCEPT_ERROR (4 * 0x1p-24f)
#define INTERCEPT_FLOOR 0x1p-110f

/* Slopes and depths of hulls are moved apart by this as well: underflow loses less. */
#define HULL_FLOOR 0x1p-110f

/* Intercepts add this times X R rho to the bound of an edge function, and their own error times R rho (L5, leaf.h). */
#define BLUR_OF_INTERCEPT (13 * 0x1p-24f)

/* After hits: lowers `last` of packets to the greatest depth at which a nearer hit may be. */
static MLRT_NOINLINE void update_last_depths(struct mlrt_bundle *bundle, uint32_t places)
{
    float *last = bundle->hulls.last;
    for (int first = 0; first < MLRT_BUNDLE_PACKETS; first += VW) {
        uint32_t left = places >> first & ALL_LANES;
        if (!left) continue;
        vf lasts = v_load(last + first); /* stored as a vector, as vectors are loaded from it next */
        for (; left; left &= left - 1) {
            const uint32_t place = (uint32_t)first + mlrt_lowest_bit(left);
            const uint32_t active = bundle->tile->packets[place].active;
            const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
            vf greatest = v_set1(-INFINITY);
            for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
                vf depth = v_load(rays->hi + v);
                if (bundle->has.intercepts) depth = v_sub(depth, v_load(rays->to_waist[0] + v));
                greatest = v_max(v_select(m_from_bits(active >> v), depth, v_set1(-INFINITY)), greatest);
            }
            const float depth = v_hmax(greatest);
            const float to = depth + (SLOPE_SLACK * (fabsf(depth) + bundle->hulls.filter.away[place]) + HULL_FLOOR);
            lasts = v_select(m_from_bits(left & (0u - left)), v_min(v_set1(to), lasts), lasts);
        }
        v_store(last + first, lasts);
    }
}

/* Least numbers over the rays of a packet; of those to be greatest, negated. Slopes and intercepts have two: j, l. */
enum least_term {
    LEAST_SLOPE_TERM,
    LEAST_MINUS_SLOPE = 2,
    LEAST_INTERCEPT = 4,
    LEAST_MINUS_INTERCEPT = 6,
    LEAST_FIRST = 8, /* the depth at which a ray begins */
    LEAST_MINUS_FIRST,
    LEAST_MINUS_LAST, /* that after which it ends (hi) */
    LEAST_LAST,       /* that before which it does not end (lo) */
    LEAST_TERMS
};

/* Stores these numbers of a packet in its hull. */
MLRT_INLINE void keep_extremes(const float least[LEAST_TERMS], uint32_t place, struct mlrt_hulls *hulls)
{
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        hulls->term[MLRT_SLOPE_J + i].lo[place] = least[LEAST_SLOPE_TERM + i];
        hulls->term[MLRT_SLOPE_J + i].hi[place] = -least[LEAST_MINUS_SLOPE + i];
        hulls->term[MLRT_INTERCEPT_J + i].lo[place] = least[LEAST_INTERCEPT + i];
        hulls->term[MLRT_INTERCEPT_J + i].hi[place] = 0 - least[LEAST_MINUS_INTERCEPT + i];
    }
    hulls->first[place] = least[LEAST_FIRST];
    hulls->closed.common_first[place] = -least[LEAST_MINUS_FIRST];
    hulls->last[place] = -least[LEAST_MINUS_LAST];
    hulls->closed.common_last[place] = least[LEAST_LAST];
}

/* Bounds a packet again, by the rays that are still active. */
static MLRT_NOINLINE void bound_packet(struct mlrt_bundle *bundle, uint32_t place)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const uint32_t active = bundle->tile->packets[place].active;
    const vf inf = v_set1(INFINITY);
    vf least[LEAST_TERMS];
    for (int i = 0; i < LEAST_TERMS; ++i) least[i] = inf;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm lanes = m_from_bits(active >> v);
        const vf to_waist = v_load(rays->to_waist[0] + v), zero = v_set1(0);
        MLRT_UNROLL
        for (int i = 0; i < MLRT_MOMENT; ++i) {
            const vf value = i < 2 || bundle->has.intercepts ? v_load(rays->term[i] + v) : zero;
            const int at = (i < 2 ? LEAST_SLOPE_TERM : LEAST_INTERCEPT) + (i & 1);
            least[at] = v_min(v_select(lanes, value, inf), least[at]);
            least[at + 2] = v_min(v_select(lanes, v_sub(zero, value), inf), least[at + 2]);
        }
        const vf first = v_sub(v_load(rays->begin + v), to_waist);
        least[LEAST_FIRST] = v_min(v_select(lanes, first, inf), least[LEAST_FIRST]);
        least[LEAST_MINUS_FIRST] = v_min(v_select(lanes, v_sub(zero, first), inf), least[LEAST_MINUS_FIRST]);
        least[LEAST_MINUS_LAST] =
            v_min(v_select(lanes, v_sub(to_waist, v_load(rays->hi + v)), inf), least[LEAST_MINUS_LAST]);
        least[LEAST_LAST] = v_min(v_select(lanes, v_sub(v_load(rays->lo + v), to_waist), inf), least[LEAST_LAST]);
    }
    MLRT_ALIGNED(16) float of[LEAST_TERMS];
    MLRT_UNROLL
    for (int i = 0; i < LEAST_TERMS; i += 4)
        f4_store(of + i, v_hmin4(least[i], least[i + 1], least[i + 2], least[i + 3]));
    keep_extremes(of, place, &bundle->hulls);
}

/* Do all rays of a packet start at the waist, `apex` (not in units)? If so, sets apex and has.apex of the packet. */
MLRT_INLINE int starts_at_waist(const float apex[3], struct mlrt_packet *packet)
{
    vm same = m_from_bits(ALL_LANES);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vf w = v_set1(apex[k]);
        if (packet->has.apex) same = m_and(same, v_eq(v_set1(packet->apex[k]), w));
        for (int v = 0; !packet->has.apex && v < MLRT_PACKET_RAYS; v += VW) {
            same = m_and(same, v_eq(v_load(packet->origin[k] + v), w));
        }
    }
    if (m_bits(same) != ALL_LANES) return 0;
    for (int k = 0; k < 3 && !packet->has.apex; ++k) packet->apex[k] = packet->origin[k][0];
    packet->has.apex = 1;
    return 1;
}

/* Copies an active ray to all lanes that are not active, so that none has to be masked when the packet is bounded. */
static MLRT_NOINLINE void fill_idle_lanes(struct mlrt_packet *packet)
{
    const uint32_t first = mlrt_lowest_bit(packet->active);
    for (uint32_t left = ~packet->active & 0xFFFF; left; left &= left - 1) {
        const uint32_t lane = mlrt_lowest_bit(left);
        for (int k = 0; k < 3; ++k) {
            packet->direction[k][lane] = packet->direction[k][first];
            if (!packet->has.apex) packet->origin[k][lane] = packet->origin[k][first];
        }
        packet->t_min[lane] = packet->t_min[first];
        packet->t_max[lane] = packet->t_max[first];
    }
}

/* Takes the minimum of a value and *least, lane by lane. For the first vector of a packet, sets *least. */
MLRT_INLINE void take_least(vf value, int v, vf *least)
{
    *least = v ? v_min(value, *least) : value;
}

/*
 * Bounds a packet whose rays have just been read. has_intercepts is 0 if they all start at the waist. Returns the lanes
 * whose rays can be traced with the bundle; hulls_fit checks the rest. If a lane is missing, the bounds are not valid.
 *
 * Slopes are products with a reciprocal here, and quotients in make_lanes: see "RAYS" above.
 */
MLRT_INLINE uint32_t bound_rays_by(struct mlrt_bundle *bundle, uint32_t place, int has_intercepts)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_hulls *hulls = &bundle->hulls;
    const int has_ends = packet->has.limits || packet->t_max[0] != INFINITY;
    const vf unit = v_set1(bundle->scene.unit), zero = v_set1(0);
    vf least[LEAST_TERMS];
    vf longest = zero;
    uint32_t fit = 0;
    if (MLRT_UNLIKELY(packet->active != 0xFFFF)) {
        if (packet->in_double) return 0; /* fill_idle_lanes must not overwrite these */
        fill_idle_lanes(packet);
    }
    for (int i = LEAST_INTERCEPT; i <= LEAST_MINUS_FIRST; ++i) least[i] = zero;
    least[LEAST_MINUS_LAST] = v_set1(-INFINITY), least[LEAST_LAST] = v_set1(INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        struct given_rays rays;
        load_given_rays(bundle, packet, has_intercepts, v, &rays);
        const vf pace = v_mul(rays.pace, unit), inverse = v_div(v_set1(1), rays.pace);
        vf term[4] = {zero, zero, zero, zero}, first = rays.from_waist[0];
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            term[i] = v_mul(rays.across[i], inverse);
            take_least(term[i], v, &least[LEAST_SLOPE_TERM + i]);
            take_least(v_sub(zero, term[i]), v, &least[LEAST_MINUS_SLOPE + i]);
            if (!has_intercepts) continue;
            term[2 + i] = v_sub(rays.from_waist[1 + i], v_mul(term[i], rays.from_waist[0]));
            take_least(term[2 + i], v, &least[LEAST_INTERCEPT + i]);
            take_least(v_sub(zero, term[2 + i]), v, &least[LEAST_MINUS_INTERCEPT + i]);
        }
        /* If an intercept, or a slope, is infinite or a NaN, so is the sum. */
        const vf sum = has_intercepts ? v_add(v_abs(term[2]), v_abs(term[3])) : v_add(v_abs(term[0]), v_abs(term[1]));
        vm fits = m_and(v_ge(pace, v_set1(LEAST_PACE)), v_le(pace, v_set1(GREATEST_PACE)));
        fits = m_and(fits, v_le(sum, v_set1(MLRT_SAFE_MAX)));
        if (MLRT_UNLIKELY(bundle->scene.unit < 1) && has_intercepts) { /* nor may 1 / |d_main| be denormal (L2) */
            fits = m_and(fits, m_and(exact_in_units(bundle, packet, v), v_le(rays.pace, v_set1(GREATEST_PACE))));
        }
        if (packet->has.limits) {
            const vf given = v_load(packet->t_min + v), begin = v_mul(v_max(given, zero), pace);
            fits = m_and(fits, m_and(v_eq(given, given), v_lt(given, v_load(packet->t_max + v))));
            longest = v_max(begin, longest);
            first = v_add(first, begin);
        }
        if (has_ends) {
            const vf t_max = v_load(packet->t_max + v), last = v_mul_add(t_max, pace, rays.from_waist[0]);
            fits = m_and(fits, v_gt(t_max, zero));
            take_least(v_sub(zero, last), v, &least[LEAST_MINUS_LAST]);
            take_least(last, v, &least[LEAST_LAST]);
        }
        take_least(first, v, &least[LEAST_FIRST]);
        take_least(v_sub(zero, first), v, &least[LEAST_MINUS_FIRST]);
        fit |= m_bits(fits) << v;
    }
    MLRT_ALIGNED(16) float of[LEAST_TERMS] = {0};
    MLRT_UNROLL
    for (int i = 0; i < LEAST_TERMS; i += 4) {
        if (has_intercepts || i != LEAST_INTERCEPT)
            f4_store(of + i, v_hmin4(least[i], least[i + 1], least[i + 2], least[i + 3]));
    }
    hulls->begin[place] = packet->has.limits ? v_hmax(longest) : 0;
    keep_extremes(of, place, hulls);
    return fit;
}

/* Bounds a packet, wherever its rays start. Returns the lanes whose rays can be traced with the bundle. */
static MLRT_NOINLINE uint32_t bound_rays(struct mlrt_bundle *bundle, uint32_t place)
{
    const int is_apex = bundle->has.apex && starts_at_waist(bundle->apex, &bundle->tile->packets[place]);
    bundle->state.apexes |= (uint32_t)is_apex << place;
    return is_apex ? bound_rays_by(bundle, place, 0) : bound_rays_by(bundle, place, 1);
}

/* By its hull, may a packet have slopes between -LEAST_SLOPE and LEAST_SLOPE? */
MLRT_INLINE int may_have_tiny_slopes(const struct mlrt_hulls *hulls, uint32_t place)
{
    int may = 0;
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i)
        may |= hulls->term[i].lo[place] < LEAST_SLOPE && hulls->term[i].hi[place] > -LEAST_SLOPE;
    return may;
}

/*
 * Sets A of packets that were bounded. Returns those that float carries: slopes are neither steep nor tiny, and origins
 * are near enough. For A (L3): the depth of an origin is within `begin` of the depth where the ray begins,
 * |o_j| <= |x_j| + |s_j o_main|, and 2 |s_j| <= R.
 */
static MLRT_NOINLINE uint32_t hulls_fit(struct mlrt_bundle *bundle, uint32_t places)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const float *w = bundle->waist.point, half = 0.5f * bundle->scene.reach;
    const int is_near = fabsf(w[0]) < half && fabsf(w[1]) < half && fabsf(w[2]) < half;
    const vf farthest = v_set1(is_near ? half : 0); /* from the waist: so origins are safe, and within reach */
    uint32_t fit = 0, small = 0;
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const vf least = v_set1(LEAST_SLOPE), below = v_set1(-LEAST_SLOPE), zero = v_set1(0), two = v_set1(2);
        const vf first = v_load(hulls->first + v), common_first = v_load(hulls->closed.common_first + v);
        vm fits = v_le(common_first, v_set1(MLRT_BVH_FAR)), is_small = m_from_bits(0);
        vf steepest = v_set1(0.5f), aside = zero;
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const vf lo = v_load(hulls->term[i].lo + v), hi = v_load(hulls->term[i].hi + v);
            const vf from = v_load(hulls->term[MLRT_INTERCEPT_J + i].lo + v),
                     to = v_load(hulls->term[MLRT_INTERCEPT_J + i].hi + v);
            steepest = v_max(v_max(v_abs(lo), v_abs(hi)), steepest);
            aside = v_max(v_max(v_abs(from), v_abs(to)), aside);
            fits = m_and(fits, m_and(v_ge(lo, v_set1(-STEEPEST_SLOPE)), v_le(hi, v_set1(STEEPEST_SLOPE))));
            const vm is_zero = m_and(v_eq(lo, zero), v_eq(hi, zero));
            is_small = m_or(is_small, m_andnot(m_and(v_lt(lo, least), v_gt(hi, below)), is_zero));
        }
        const vf deep = v_add(v_max(v_abs(first), v_abs(common_first)), v_load(hulls->begin + v));
        const vf away = v_mul(v_mul(v_mul_add(steepest, deep, aside), two), v_set1(1 + SLOPE_SLACK));
        v_store(hulls->filter.away + v, v_select(m_from_bits(places >> v), away, v_load(hulls->filter.away + v)));
        fit |= m_bits(m_and(fits, v_le(away, farthest))) << v;
        small |= m_bits(is_small) << v;
    }
    fit &= places;
    for (uint32_t left = small & fit; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        if (has_tiny_slopes(bundle, &bundle->tile->packets[place])) fit &= ~(1u << place);
    }
    return fit;
}

/*
 * For the packets `places` of a vector: moves the depths of their hulls apart by more than rounding can change (L13),
 * and cuts them to those of the scene. The depths between which all rays look (common_first, common_last) are moved
 * closer.
 */
MLRT_INLINE void finish_depths(struct mlrt_bundle *bundle, uint32_t places, int v)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const vm these = m_from_bits(places >> v);
    const vf first = v_load(hulls->first + v), last = v_load(hulls->last + v), away = v_load(hulls->filter.away + v);
    const vf slack = v_set1(SLOPE_SLACK), floor = v_set1(HULL_FLOOR);
    const vf from = v_sub(first, v_mul_add(v_add(v_abs(first), away), slack, floor));
    const vf to = v_add(last, v_mul_add(v_add(v_abs(last), away), slack, floor));
    v_store(hulls->first + v, v_select(these, v_max(from, v_set1(bundle->scene.first)), first));
    v_store(hulls->last + v, v_select(these, v_min(to, v_set1(bundle->scene.last)), last));
    const vf common_first = v_load(hulls->closed.common_first + v);
    const vf common_last = v_min(v_load(hulls->closed.common_last + v), v_set1(FLT_MAX)); /* else inf - inf is a NaN */
    const vf common_from = v_add(common_first, v_mul_add(v_add(v_abs(common_first), away), slack, floor));
    const vf common_to = v_sub(common_last, v_mul_add(v_add(v_abs(common_last), away), slack, floor));
    v_store(hulls->closed.common_first + v, v_select(these, common_from, common_first));
    v_store(hulls->closed.common_last + v, v_select(these, common_to, common_last));
}

/*
 * Sets middle and radius of the moment s_l x_j - s_j x_l from those of its factors: the products of the middles, and
 * all products in which a radius takes part. 4 u of the former and 16 u of the latter cover the roundings (L10).
 */
MLRT_INLINE void product_over_hull(const vf *middle, const vf *radius, vf *of_moment, vf *around)
{
    const vf first = v_mul(middle[MLRT_SLOPE_L], middle[MLRT_INTERCEPT_J]);
    const vf second = v_mul(middle[MLRT_SLOPE_J], middle[MLRT_INTERCEPT_L]);
    vf sum = v_set1(0);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        const vf slope = radius[MLRT_SLOPE_J + i], at = radius[MLRT_INTERCEPT_L - i];
        sum = v_mul_add(v_add(v_abs(middle[MLRT_SLOPE_J + i]), slope), at, sum);
        sum = v_mul_add(slope, v_abs(middle[MLRT_INTERCEPT_L - i]), sum);
    }
    *of_moment = v_sub(first, second);
    sum = v_mul(sum, v_set1(1 + SLOPE_SLACK));
    *around = v_mul_add(v_add(v_abs(first), v_abs(second)), v_set1(0.25f * SLOPE_SLACK), sum);
}

/*
 * Makes the hulls of the vector of packets from `v` on, from the extremes of their rays (keep_extremes).
 *
 * Middles and radii need no floor (L10): underflow loses less than 2^-148 of a term, coefficients are at most 2^21, and
 * the bound of an edge function has 0.9 u R to spare. The ends of slopes need HULL_FLOOR, and those of intercepts
 * INTERCEPT_FLOOR: they are compared with boxes, which may be as near as a denormal.
 */
static MLRT_NOINLINE void finish_hulls(struct mlrt_bundle *bundle, int v)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const vm going = m_from_bits(bundle->state.going >> v);
    const vf away = v_load(hulls->filter.away + v), one = v_set1(1), inf = v_set1(INFINITY), none = v_set1(-INFINITY);
    vf direction_size = one, largest = v_set1(0), middle[MLRT_RAY_TERMS], radius[MLRT_RAY_TERMS];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i) {
        const vf lo = v_load(hulls->term[i].lo + v), hi = v_load(hulls->term[i].hi + v);
        const vf size = v_max(v_abs(lo), v_abs(hi));
        middle[i] = v_mul(v_add(lo, hi), v_set1(0.5f));
        radius[i] = v_mul(v_sub(hi, lo), v_set1(0.5f * (1 + SLOPE_SLACK)));
        radius[i] = v_mul_add(v_abs(middle[i]), v_set1(0.5f * SLOPE_SLACK), radius[i]);
        if (i < 2) direction_size = v_max(v_mul(size, v_set1(2)), direction_size);
        if (i >= 2) largest = v_max(size, largest);
    }
    product_over_hull(middle, radius, &middle[MLRT_MOMENT], &radius[MLRT_MOMENT]);
    MLRT_UNROLL
    for (int i = 0; i < MLRT_RAY_TERMS; ++i) {
        v_store(hulls->filter.middle[i] + v, middle[i]);
        v_store(hulls->filter.radius[i] + v, radius[i]);
    }
    const vf error = v_mul_add(v_mul(direction_size, away), v_set1(INTERCEPT_ERROR), v_set1(INTERCEPT_FLOOR));
    v_store(hulls->filter.direction_size + v, direction_size);
    v_store(hulls->filter.blur + v, v_mul_add(largest, v_set1(BLUR_OF_INTERCEPT), error));
    const vf slack = v_set1(SLOPE_SLACK);
    MLRT_UNROLL
    for (int i = 0; i < MLRT_MOMENT; ++i) {
        const vf lo = v_load(hulls->term[i].lo + v), hi = v_load(hulls->term[i].hi + v);
        const vf floor = i < MLRT_INTERCEPT_J ? v_set1(HULL_FLOOR) : error;
        v_store(hulls->moved[i].lo + v, v_select(going, v_sub(lo, v_mul_add(v_abs(lo), slack, floor)), inf));
        v_store(hulls->moved[i].hi + v, v_select(going, v_add(hi, v_mul_add(v_abs(hi), slack, floor)), none));
    }
}

MLRT_INLINE void set_whole_last(struct mlrt_bundle *bundle)
{
    vf last = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) last = v_max(v_load(bundle->hulls.last + v), last);
    bundle->whole.last = v_hmax(last);
}

/* Sets the hull of all packets of the bundle. */
static MLRT_NOINLINE void sum_up_hulls(struct mlrt_bundle *bundle)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    struct mlrt_hull *whole = &bundle->whole;
    struct extremes of[MLRT_MOMENT] = {NO_EXTREMES, NO_EXTREMES, NO_EXTREMES, NO_EXTREMES};
    vf first = v_set1(INFINITY);
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        MLRT_UNROLL
        for (int i = 0; i < MLRT_MOMENT; ++i) {
            of[i].least = v_min(v_load(hulls->moved[i].lo + v), of[i].least);
            of[i].negated = v_min(v_sub(v_set1(0), v_load(hulls->moved[i].hi + v)), of[i].negated);
        }
        first = v_min(v_load(hulls->first + v), first);
    }
    MLRT_ALIGNED(16) float least[4], negated[4];
    f4_store(least, v_hmin4(of[0].least, of[1].least, of[2].least, of[3].least));
    f4_store(negated, v_hmin4(of[0].negated, of[1].negated, of[2].negated, of[3].negated));
    MLRT_UNROLL
    for (int i = 0; i < MLRT_MOMENT; ++i) whole->lo[i] = least[i], whole->hi[i] = -negated[i];
    whole->first = v_hmin(first);
    set_whole_last(bundle);
}

/* Takes a packet out of the bundle. */
static void leave_bundle(struct mlrt_bundle *bundle, uint32_t place)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->state.going &= ~(1u << place);
    hulls->first[place] = INFINITY;
    hulls->last[place] = -INFINITY;
    MLRT_UNROLL
    for (int i = 0; i < MLRT_MOMENT; ++i) hulls->moved[i].lo[place] = INFINITY, hulls->moved[i].hi[place] = -INFINITY;
}

#endif
