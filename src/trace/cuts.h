/* SPDX-License-Identifier: MIT */
/*
 * Which triangles of a leaf the rays of a packet may hit, by its hull: by outlines (outline.h), then by edges.
 *
 * Over a hull, an edge function lies within its value at the middles of the terms, less and plus the sum of
 * |coefficient| radius. By L11 this interval, as computed, misses the edge function of a ray by at most
 * 14.002 u R + (13.2 u X + 1.01 E) R rho, and that of D misses D by at most 11.1 u R: twice the bound for a single ray
 * is enough for both.
 */
#ifndef MLRT_TRACE_CUTS_H
#define MLRT_TRACE_CUTS_H

#include <math.h>

#include "hits/triangle_filter.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/leaf.h"
#include "trace/outline.h"

/* Bounds edge functions, or D, of a vector of triangles over the hull of a packet; rounding errors come on top. */
MLRT_INLINE void bound_over_hull(const struct mlrt_hulls *hulls, uint32_t place, const float *constant,
                                 const float (*coefficient)[MLRT_BVH_LEAF_LIMIT], int term_count, vf *least,
                                 vf *greatest)
{
    vf middle = v_load(constant), radius = v_set1(0);
    MLRT_UNROLL
    for (int i = 0; i < term_count; ++i) {
        const vf c = v_load(coefficient[i]);
        middle = v_mul_add(c, v_set1(hulls->filter.middle[i][place]), middle);
        radius = v_mul_add(v_abs(c), v_set1(hulls->filter.radius[i][place]), radius);
    }
    *least = v_sub(middle, radius);
    *greatest = v_add(middle, radius);
}

/* Error bounds of the edge functions of a vector of triangles, for the rays of a packet (L5). */
MLRT_INLINE vf edge_bounds(const struct mlrt_hulls *hulls, uint32_t place, vf steepness, int has_places)
{
    const vf bound = v_set1(EDGE_ERROR * hulls->filter.reach[place]);
    if (!has_places || MLRT_GUESS) return bound;
    return v_mul_add(steepness, v_set1(hulls->filter.blur[place] * hulls->filter.reach[place]), bound);
}

/*
 * Returns the triangles of `among` that the rays of a packet may hit. A triangle is left out if all rays pass outside
 * of one edge, and D has one sign; or if all rays pass two edges on different sides. For rays from the waist a hit
 * has no negative edge function (leaf.h, "FROM THE WAIST").
 */
MLRT_INLINE uint32_t triangles_within_edges(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                            uint32_t place, int has_places, uint32_t among)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const int term_count = has_places ? MLRT_RAY_TERMS : 2;
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!(among >> v & ALL_LANES)) continue;
        vf lowest = v_set1(INFINITY), highest = v_set1(-INFINITY), least, greatest;
        MLRT_UNROLL
        for (int i = 0; i < 3; ++i) {
            bound_over_hull(hulls, place, leaf->edges.constant[i] + v,
                            (const float(*)[MLRT_BVH_LEAF_LIMIT])(leaf->edges.coefficient[i][0] + v), term_count,
                            &least, &greatest);
            lowest = v_min(greatest, lowest);
            highest = v_max(least, highest);
        }
        const vf bound = v_mul(edge_bounds(hulls, place, v_load(leaf->edges.steepness + v), has_places), v_set1(2));
        if (!has_places) {
            met |= (~m_bits(v_lt(lowest, v_sub(v_set1(0), bound))) & ALL_LANES) << v;
            continue;
        }
        bound_over_hull(hulls, place, leaf->planes.normal[0] + v,
                        (const float(*)[MLRT_BVH_LEAF_LIMIT])(leaf->planes.normal[1] + v), 2, &least, &greatest);
        const vf width = v_set1(2 * PLANE_BOUND * hulls->filter.reach[place]);
        const vm below = v_lt(lowest, v_sub(v_set1(0), bound)), above = v_gt(highest, bound);
        const vm forward = v_gt(least, width), backward = v_lt(greatest, v_sub(v_set1(0), width));
        const vm out = m_or(m_and(below, m_or(above, forward)), m_and(above, backward));
        met |= (~m_bits(out) & ALL_LANES) << v;
    }
    return met & among;
}

/* Returns the triangles of `seen` that a packet may hit, by outlines and then by edges. */
MLRT_INLINE uint32_t cut_triangles_by(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                      uint32_t place, int has_places, uint32_t seen)
{
    struct mlrt_hull hull;
    take_hull(bundle, place, &hull);
    const uint32_t met = triangles_met(bundle, leaf, &hull, has_places, seen);
    return met ? triangles_within_edges(bundle, leaf, place, has_places, met) : 0;
}

static MLRT_NOINLINE uint32_t cut_triangles(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                            uint32_t place, uint32_t seen)
{
    return bundle->has.places ? cut_triangles_by(bundle, leaf, place, 1, seen)
                              : cut_triangles_by(bundle, leaf, place, 0, seen);
}

#endif
