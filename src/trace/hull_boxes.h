/* SPDX-License-Identifier: MIT */
/*
 * Hulls against boxes: which boxes a bundle, its packets and their rays may meet.
 *
 * ERRORS (L12 of docs/accuracy.md, "Bundles"), u = 2^-24. At depth z a ray is at x_j + s_j z. Of a box, c = fl(c_j -
 * w_j) and z = fl(c_main - w_main) are off by u of themselves; the product with a slope, and its sum with an intercept,
 * by u each. Slopes and intercepts of hulls are moved apart by SLOPE_SLACK, 2^-20 of themselves, and intercepts by
 * INTERCEPT_ERROR R A as well: these are 16 u |s| |z| and 16 u |x|. A box is compared as c <= fl(x + fl(s z)). Both
 * sides are off by at most 3 u |s z| + 3 u (|x| + |s z|); u |c| matters only where c is as large as the other side.
 *
 * Based on: I. Wald, S. Boulos, P. Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies",
 * 2007 (frusta against boxes).
 */
#ifndef MLRT_TRACE_HULL_BOXES_H
#define MLRT_TRACE_HULL_BOXES_H

#include <math.h>

#include "bvh/node.h"
#include "rays/extremes.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/ray_hulls.h"
#include "trace/ray_tile.h"

/*
 * The greatest and the least that rays with these slopes and intercepts can have of one component between the depths
 * `from` and `to`. If `to` is infinite, its product with a slope 0 is a NaN, which v_max and v_min drop, as it is their
 * first operand.
 */
MLRT_INLINE vf greatest_across(vf from, vf to, vf slope_lo, vf slope_hi, vf intercept_hi, int has_intercepts)
{
    if (!has_intercepts) return v_max(v_mul(slope_hi, to), v_mul(slope_hi, from));
    return v_add(intercept_hi, v_max(v_max(v_mul(slope_hi, to), v_mul(slope_hi, from)),
                                     v_max(v_mul(slope_lo, to), v_mul(slope_lo, from))));
}

MLRT_INLINE vf least_across(vf from, vf to, vf slope_lo, vf slope_hi, vf intercept_lo, int has_intercepts)
{
    if (!has_intercepts) return v_min(v_mul(slope_lo, to), v_mul(slope_lo, from));
    return v_add(intercept_lo, v_min(v_min(v_mul(slope_hi, to), v_mul(slope_hi, from)),
                                     v_min(v_mul(slope_lo, to), v_mul(slope_lo, from))));
}

/*
 * The greatest s z for slopes s within lo .. hi and depths z within `from` .. `to`. With -hi and -lo in place of lo and
 * hi it is the negative of the least. If all slopes have one sign, it is at one end of the depths. These may be
 * infinite: then a product with a slope 0 is a NaN, which v_max drops as its first operand. Not all slopes are 0, by
 * HULL_FLOOR.
 */
MLRT_INLINE vf greatest_product(vf from, vf to, float lo, float hi, int has_intercepts)
{
    if (!has_intercepts) return v_mul(v_set1(hi), hi > 0 ? to : from);
    const int is_up = hi + lo > 0;
    const vf less = v_set1(is_up ? lo : hi), more = v_set1(is_up ? hi : lo), end = is_up ? to : from;
    const vf there = v_max(v_mul(less, end), v_mul(more, end));
    if (lo > 0 || hi < 0) return there;
    const vf other = is_up ? from : to;
    return v_max(v_max(v_mul(less, other), v_mul(more, other)), there);
}

/* Returns the children of a node with boxes that the bundle may meet, and sets `near` to their least depths. */
MLRT_INLINE uint32_t bundle_children_met(const struct mlrt_bundle *bundle, const struct mlrt_bvh_node *node,
                                         int has_intercepts, float near[MLRT_BVH_WIDTH])
{
    const struct mlrt_waist *waist = &bundle->waist;
    const struct mlrt_hull *whole = &bundle->whole;
    const int a = waist->main_axis;
    const float *enter = waist->sign > 0 ? node->lo[a] : node->hi[a],
                *exit = waist->sign > 0 ? node->hi[a] : node->lo[a];
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) {
        const vf w = v_set1(waist->point[a]), sign = v_set1(waist->sign);
        const vf from = v_max(v_flip(v_sub(v_load(enter + v), w), sign), v_set1(whole->first));
        const vf to = v_min(v_flip(v_sub(v_load(exit + v), w), sign), v_set1(whole->last));
        vm may = v_le(from, to);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const int j = mlrt_slope_axis(a, i);
            const float lo = whole->lo[MLRT_SLOPE_J + i], hi = whole->hi[MLRT_SLOPE_J + i];
            vf upper = greatest_product(from, to, lo, hi, has_intercepts);
            vf minus_lower = greatest_product(from, to, -hi, -lo, has_intercepts);
            const vf least = v_sub(v_load(node->lo[j] + v), v_set1(waist->point[j]));
            const vf minus_greatest = v_sub(v_set1(waist->point[j]), v_load(node->hi[j] + v));
            if (has_intercepts) {
                upper = v_add(upper, v_set1(whole->hi[MLRT_INTERCEPT_J + i]));
                minus_lower = v_sub(minus_lower, v_set1(whole->lo[MLRT_INTERCEPT_J + i]));
            }
            may = m_and(may, m_and(v_le(least, upper), v_le(minus_greatest, minus_lower)));
        }
        v_store(near + v, from);
        met |= m_bits(may) << v;
    }
    return met;
}

/* The box of a child, relative to the waist: from .. to in depth, lo .. hi in j and l. */
struct box_of_bundle {
    float from;
    float to;
    float lo[2];
    float hi[2];
};

MLRT_INLINE void see_bundle_box(const struct mlrt_waist *waist, const struct mlrt_bvh_node *node, uint32_t place,
                                struct box_of_bundle *box)
{
    const int a = waist->main_axis;
    const float below = node->lo[a][place] - waist->point[a], above = node->hi[a][place] - waist->point[a];
    box->from = waist->sign > 0 ? below : -above;
    box->to = waist->sign > 0 ? above : -below;
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        const int j = mlrt_slope_axis(a, i);
        box->lo[i] = node->lo[j][place] - waist->point[j];
        box->hi[i] = node->hi[j][place] - waist->point[j];
    }
}

/* Returns the packets that may meet a box. Without intercepts whole.first serves for all: rays start at the waist. */
MLRT_INLINE uint32_t packets_met(const struct mlrt_bundle *bundle, const struct box_of_bundle *box, int has_intercepts)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const float begin = larger_of(box->from, bundle->whole.first);
    uint32_t met = 0;
    if (!(box->to >= begin)) return 0;
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        vf from = v_set1(begin), to = v_set1(box->to), last = v_load(hulls->last + v);
        if (has_intercepts) {
            from = v_max(from, v_load(hulls->first + v));
            to = last = v_min(to, last);
        }
        vm may = v_le(from, last);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const struct mlrt_hull_row *slope = &hulls->moved[MLRT_SLOPE_J + i],
                                       *at = &hulls->moved[MLRT_INTERCEPT_J + i];
            const vf lo = v_load(slope->lo + v), hi = v_load(slope->hi + v);
            const vf intercept_lo = has_intercepts ? v_load(at->lo + v) : lo;
            const vf intercept_hi = has_intercepts ? v_load(at->hi + v) : hi;
            may = m_and(may, v_le(v_set1(box->lo[i]), greatest_across(from, to, lo, hi, intercept_hi, has_intercepts)));
            may = m_and(may, v_ge(v_set1(box->hi[i]), least_across(from, to, lo, hi, intercept_lo, has_intercepts)));
        }
        met |= m_bits(may) << v;
    }
    return met;
}

/* Returns the active rays of a packet that may meet a box: with the slack of hulls (L12). */
MLRT_INLINE uint32_t lanes_of_packet_met(const struct mlrt_bundle *bundle, uint32_t place,
                                         const struct box_of_bundle *box)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const float deepest = larger_of(fabsf(hulls->first[place]), fabsf(hulls->last[place]));
    float far = 0;
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        const struct mlrt_hull_row *at = &hulls->moved[MLRT_INTERCEPT_J + i];
        far = larger_of(larger_of(fabsf(at->lo[place]), fabsf(at->hi[place])), far);
    }
    const float size = hulls->filter.direction_size[place];
    const vf slack =
        v_set1(SLOPE_SLACK * (far + size * deepest) + INTERCEPT_ERROR * size * hulls->filter.away[place] + HULL_FLOOR);
    uint32_t met = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf last = v_sub(v_load(rays->hi + v), v_load(rays->to_waist[0] + v));
        const vf moved = v_add(last, v_set1(SLOPE_SLACK * (deepest + hulls->filter.away[place]) + HULL_FLOOR));
        const vf from = v_max(v_set1(box->from), v_set1(hulls->first[place]));
        const vf to = v_min(v_min(v_set1(box->to), v_set1(hulls->last[place])), moved);
        vm may = v_le(from, to);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const vf slope = v_load(rays->term[MLRT_SLOPE_J + i] + v);
            const vf x = bundle->has.intercepts ? v_load(rays->term[MLRT_INTERCEPT_J + i] + v) : v_set1(0);
            const vf one = v_mul_add(slope, from, x), other = v_mul_add(slope, to, x);
            may = m_and(may, v_le(v_set1(box->lo[i]), v_add(v_max(one, other), slack)));
            may = m_and(may, v_ge(v_set1(box->hi[i]), v_sub(v_min(one, other), slack)));
        }
        met |= m_bits(may) << v;
    }
    return met & bundle->tile->packets[place].active;
}

#endif
