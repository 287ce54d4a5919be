/* SPDX-License-Identifier: MIT */
/*
 * Outlines: where the triangles of a leaf are as seen from a bundle's waist. An outline is an interval for each of two
 * axes, and a hull whose slopes or intercepts lie outside of one misses the triangle (L16 in docs/accuracy.md,
 * "Bundles").
 *
 * FANS. Let a triangle lie wholly on one side of the waist: z has one sign. A ray that hits it at p, depth z, has the
 * slope s = p_j / z - x / z. p_j / z lies between its values at the corners, since a projection keeps triangles convex;
 * x / z is at most the greatest |x| over the least |z|. So a hull misses the triangle unless
 *
 *     lo <= s_hi + |x| weight   and   hi >= s_lo - |x| weight,    lo, hi of p_j / z,  weight = 1 / least |z|.
 *
 * BEAMS. Other triangles are seen along t, the slope of the waist, which nearly all rays have if they are parallel. A
 * ray that hits p has the intercept x = (p_j - t z) - (s - t) z. So a hull misses the triangle unless
 *
 *     lo <= x_hi + |s - t| weight   and   hi >= x_lo - |s - t| weight,    lo, hi of p_j - t z,  weight = greatest |z|.
 *
 * ROUNDING, u = 2^-24. p_j and z have one rounding each, 1 / z and the product two more: lo and hi of fans are off by
 * 4 u of themselves, and are moved apart by SLOPE_SLACK, which is 16 u. p_j - t z is off by 4 u (|p_j| + |t z|), and
 * is moved by 16 u of that. Weights have at most two roundings, and are made larger by 16 u. Slopes and intercepts of
 * hulls are moved apart by 16 u of themselves and HULL_FLOOR or INTERCEPT_FLOOR, too (ray_hulls.h): this covers the
 * roundings of the sums.
 *
 * RANGE. |p_j| is at most 2^61. A fan's |z| is more than 2^-60, so p_j / z is less than 2^122. An infinite end would
 * become a NaN when it is moved by a share of itself; and as no comparison with a NaN is true, the triangle would be
 * left out.
 */
#ifndef MLRT_TRACE_OUTLINE_H
#define MLRT_TRACE_OUTLINE_H

#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"

/* A triangle that comes nearer to the waist, in depth, is not a fan. */
#define LEAST_FAN_DEPTH 0x1p-60f

/* The greatest |s - t| of a hull. */
MLRT_INLINE vf greatest_turn(const struct mlrt_waist *waist, int side, vf lo, vf hi)
{
    const vf slope = v_set1(waist->slope[side]);
    return v_mul(v_max(v_abs(v_sub(lo, slope)), v_abs(v_sub(hi, slope))), v_set1(1 + SLOPE_SLACK));
}

/* Takes the hull of one packet. */
MLRT_INLINE void take_hull(const struct mlrt_bundle *bundle, uint32_t place, struct mlrt_hull *of)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    of->first = hulls->first[place];
    of->last = hulls->last[place];
    MLRT_UNROLL
    for (int i = 0; i < MLRT_MOMENT; ++i) of->lo[i] = hulls->moved[i].lo[place], of->hi[i] = hulls->moved[i].hi[place];
}

/*
 * Sets the outlines of a vector of triangles, of which `there` exist, from their corners relative to the waist. Fans
 * have a weight only if rays have intercepts; without, it is any number.
 */
MLRT_INLINE void set_outlines(const struct mlrt_waist *waist, const vf (*corner)[3], uint32_t there, uint32_t v,
                              struct mlrt_bundle_leaf *leaf)
{
    const vf a = corner[0][0], b = corner[1][0], c = corner[2][0], slack = v_set1(SLOPE_SLACK),
             wider = v_set1(1 + SLOPE_SLACK);
    const vf near = v_min(v_min(a, b), c), far = v_max(v_max(a, b), c), small = v_set1(LEAST_FAN_DEPTH);
    const vf least = v_max(near, v_sub(v_set1(0), far)), greatest = v_max(v_abs(near), v_abs(far));
    vm is_fan = v_gt(least, small);
    if (waist->is_beam) is_fan = m_from_bits(0);
    const vf scale[3] = {v_div(v_set1(1), a), v_div(v_set1(1), b), v_div(v_set1(1), c)};
    const int are_fans = !(there & ~m_bits(is_fan));
    v_store(leaf->outline.near + v, near);
    v_store(leaf->outline.far + v, far);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        vf ends[3], lo, hi;
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) ends[k] = v_mul(corner[k][1 + i], scale[k]);
        lo = v_min(v_min(ends[0], ends[1]), ends[2]);
        hi = v_max(v_max(ends[0], ends[1]), ends[2]);
        vf from = v_sub(lo, v_mul(v_abs(lo), slack)), to = v_add(hi, v_mul(v_abs(hi), slack));
        if (!are_fans) {
            const vf slope = v_set1(waist->slope[i]);
            vf size = v_set1(0);
            MLRT_UNROLL
            for (int k = 0; k < 3; ++k) {
                ends[k] = v_sub(corner[k][1 + i], v_mul(slope, corner[k][0]));
                size = v_max(v_abs(corner[k][1 + i]), size);
            }
            const vf room = v_mul(v_mul_add(v_abs(slope), greatest, size), slack);
            from = v_select(is_fan, from, v_sub(v_min(v_min(ends[0], ends[1]), ends[2]), room));
            to = v_select(is_fan, to, v_add(v_max(v_max(ends[0], ends[1]), ends[2]), room));
        }
        v_store(leaf->outline.lo[i] + v, from);
        v_store(leaf->outline.hi[i] + v, to);
    }
    const vf weight = leaf->has_intercepts ? v_select(is_fan, v_div(v_set1(1), least), greatest) : greatest;
    v_store(leaf->outline.weight + v, v_mul(weight, wider));
    leaf->state.fans |= m_bits(is_fan) << v;
}

/*
 * Sets the ends that outlines over one axis are compared with: s -+ |x| weight for fans, x -+ |s - t| weight for beams.
 * For fans without intercepts, these are the ends of the slopes.
 */
MLRT_INLINE void find_outline_ends(const struct mlrt_waist *waist, int side, vf weight, vm is_fan, int are_fans,
                                   const vf slope[2], const vf intercept[2], int has_intercepts, vf ends[2])
{
    vf widest = v_set1(0);
    ends[0] = slope[0], ends[1] = slope[1];
    if (has_intercepts) widest = v_max(v_abs(intercept[0]), v_abs(intercept[1]));
    if (MLRT_UNLIKELY(!are_fans)) {
        ends[0] = v_select(is_fan, ends[0], has_intercepts ? intercept[0] : v_set1(0));
        ends[1] = v_select(is_fan, ends[1], has_intercepts ? intercept[1] : v_set1(0));
        widest = v_select(is_fan, widest, greatest_turn(waist, side, slope[0], slope[1]));
    }
    if (has_intercepts || !are_fans) {
        const vf room = v_mul(widest, weight);
        ends[0] = v_sub(ends[0], room);
        ends[1] = v_add(ends[1], room);
    }
}

/* Returns the triangles of `among` that rays of a hull may hit, by their outlines. Most leaves have only fans. */
MLRT_INLINE uint32_t outlines_met(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                  const struct mlrt_hull *hull, int has_intercepts, uint32_t among)
{
    const int are_fans = !(among & ~leaf->state.fans);
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!(among >> v & ALL_LANES)) continue;
        const vm is_fan = m_from_bits(leaf->state.fans >> v);
        vm may = m_and(v_le(v_load(leaf->outline.near + v), v_set1(hull->last)),
                       v_ge(v_load(leaf->outline.far + v), v_set1(hull->first)));
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const vf slope[2] = {v_set1(hull->lo[MLRT_SLOPE_J + i]), v_set1(hull->hi[MLRT_SLOPE_J + i])};
            const vf intercept[2] = {v_set1(hull->lo[MLRT_INTERCEPT_J + i]), v_set1(hull->hi[MLRT_INTERCEPT_J + i])};
            vf ends[2];
            find_outline_ends(&bundle->waist, i, v_load(leaf->outline.weight + v), is_fan, are_fans, slope, intercept,
                              has_intercepts, ends);
            may = m_and(may, m_and(v_le(v_load(leaf->outline.lo[i] + v), ends[1]),
                                   v_ge(v_load(leaf->outline.hi[i] + v), ends[0])));
        }
        met |= m_bits(may) << v;
    }
    return met & among;
}

#endif
