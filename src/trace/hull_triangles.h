/* SPDX-License-Identifier: MIT */
/*
 * Hulls against the triangles of a leaf, and which of these the rays of a packet may hit: by outlines (outline.h), then
 * by edges.
 *
 * Over a hull, an edge function lies within its value at the middles of the terms, less and plus the sum of
 * |coefficient| radius. By L11 this interval, as computed, misses the edge function of a ray by at most
 * 14.002 u R + (13.2 u X + 1.01 E) R rho, and that of D misses D by at most 11.1 u R: twice the bound for a single ray
 * is enough for both.
 */
#ifndef MLRT_TRACE_HULL_TRIANGLES_H
#define MLRT_TRACE_HULL_TRIANGLES_H

#include <math.h>

#include "hits/triangle_filter.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/leaf.h"
#include "trace/outline.h"

/* A vector of packets and one triangle, or a vector of triangles and one packet. */
struct hull_pairs {
    const struct mlrt_hulls *hulls;
    const struct mlrt_bundle_leaf *leaf;
    uint32_t place;    /* of the packet, or of the first packet */
    uint32_t triangle; /* the place of the triangle, or of the first triangle */
    int are_packets;   /* 1: a vector of packets; 0: a vector of triangles */
    int has_intercepts;
};

/* What pairs have in a row of hulls, and in a row of a leaf. */
MLRT_INLINE vf hull_row(const struct hull_pairs *pairs, const float *row)
{
    return pairs->are_packets ? v_load(row + pairs->place) : v_set1(row[pairs->place]);
}

MLRT_INLINE vf leaf_row(const struct hull_pairs *pairs, const float *row)
{
    return pairs->are_packets ? v_set1(row[pairs->triangle]) : v_load(row + pairs->triangle);
}

/* Bounds edge functions, or D, over hulls; rounding errors come on top. */
MLRT_INLINE void bound_over_hulls(const struct hull_pairs *pairs, const float constant[MLRT_BVH_LEAF_LIMIT],
                                  const float (*coefficient)[MLRT_BVH_LEAF_LIMIT], int term_count, vf *least,
                                  vf *greatest)
{
    const struct mlrt_filter_hulls *filter = &pairs->hulls->filter;
    vf middle = leaf_row(pairs, constant), radius = v_set1(0);
    MLRT_UNROLL
    for (int i = 0; i < term_count; ++i) {
        const vf c = leaf_row(pairs, coefficient[i]);
        middle = v_mul_add(c, hull_row(pairs, filter->middle[i]), middle);
        radius = v_mul_add(v_abs(c), hull_row(pairs, filter->radius[i]), radius);
    }
    *least = v_sub(middle, radius);
    *greatest = v_add(middle, radius);
}

MLRT_INLINE void bound_edge(const struct hull_pairs *pairs, int i, vf *least, vf *greatest)
{
    const struct mlrt_leaf_edges *edges = &pairs->leaf->edges;
    bound_over_hulls(pairs, edges->constant[i], (const float(*)[MLRT_BVH_LEAF_LIMIT])edges->coefficient[i],
                     pairs->has_intercepts ? MLRT_RAY_TERMS : 2, least, greatest);
}

/* Error bounds of edge functions for the rays of packets (L5), multiplied by `times`. */
MLRT_INLINE vf edge_bounds(const struct hull_pairs *pairs, float times)
{
    const vf size = hull_row(pairs, pairs->hulls->filter.direction_size),
             bound = v_mul(size, v_set1(times * EDGE_ERROR));
    if (!pairs->has_intercepts || MLRT_GUESS) return bound;
    const vf steepness = v_mul(leaf_row(pairs, pairs->leaf->edges.steepness), v_set1(times));
    return v_mul_add(steepness, v_mul(hull_row(pairs, pairs->hulls->filter.blur), size), bound);
}

/* What hulls tell of triangles: for each pair, all rays of the packet and the triangle. */
struct seen_pairs {
    vm out;      /* no ray hits the triangle */
    vm inside;   /* all rays pass inside its edges */
    vm sure;     /* D has one certain sign for all rays */
    vm backward; /* this sign is -1 */
    vf least_d;  /* without rounding errors */
    vf greatest_d;
    vf near; /* where `sure`: depths between which all rays meet its plane (bound_depths, hull_order.h) */
    vf far;
};

/*
 * Sets all of *of but the depths. A triangle is left out if all rays pass outside of one edge, and D has one sign; or
 * if all rays pass two edges on different sides. For rays from the waist, a hit has no negative edge function (leaf.h,
 * "FROM THE WAIST"). D is then compared only for vectors of packets.
 */
MLRT_INLINE void see_pairs(const struct hull_pairs *pairs, struct seen_pairs *of)
{
    const struct mlrt_bundle_leaf *leaf = pairs->leaf;
    vf lowest = v_set1(INFINITY), highest = v_set1(-INFINITY), inner_low = lowest, inner_high = highest, least,
       greatest;
    MLRT_UNROLL
    for (int i = 0; i < 3; ++i) {
        bound_edge(pairs, i, &least, &greatest);
        lowest = v_min(greatest, lowest);
        highest = v_max(least, highest);
        inner_low = v_min(least, inner_low);
        inner_high = v_max(greatest, inner_high);
    }
    bound_over_hulls(pairs, leaf->planes.normal[0], (const float(*)[MLRT_BVH_LEAF_LIMIT])leaf->planes.normal + 1, 2,
                     &least, &greatest);
    const vf zero = v_set1(0), bound = edge_bounds(pairs, 2);
    const vf width = v_mul(hull_row(pairs, pairs->hulls->filter.direction_size), v_set1(2 * PLANE_BOUND));
    const vm below = v_lt(lowest, v_sub(zero, bound)), above = v_gt(highest, bound);
    const vm forward = v_gt(least, width), backward = v_lt(greatest, v_sub(zero, width));
    if (pairs->has_intercepts) {
        of->out = m_or(m_and(below, m_or(above, forward)), m_and(above, backward));
    } else {
        of->out = pairs->are_packets ? m_or(below, backward) : below;
    }
    of->inside = m_and(forward, v_gt(inner_low, bound));
    if (pairs->has_intercepts) of->inside = m_or(of->inside, m_and(backward, v_lt(inner_high, v_sub(zero, bound))));
    of->sure = m_or(forward, backward);
    of->backward = backward;
    of->least_d = least;
    of->greatest_d = greatest;
}

/* Returns the triangles of `among` that the rays of a packet may hit, by their edges. */
MLRT_INLINE uint32_t triangles_within_edges(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                            uint32_t place, int has_intercepts, uint32_t among)
{
    uint32_t met = 0;
    for (uint32_t v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        const struct hull_pairs pairs = {&bundle->hulls, leaf, place, v, 0, has_intercepts};
        struct seen_pairs of;
        if (!(among >> v & ALL_LANES)) continue;
        see_pairs(&pairs, &of);
        met |= (~m_bits(of.out) & ALL_LANES) << v;
    }
    return met & among;
}

/* Returns the triangles of `seen` that a packet may hit, by outlines and then by edges. */
MLRT_INLINE uint32_t packet_triangles_met_by(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                             uint32_t place, int has_intercepts, uint32_t seen)
{
    struct mlrt_hull hull;
    take_hull(bundle, place, &hull);
    const uint32_t met = outlines_met(bundle, leaf, &hull, has_intercepts, seen);
    return met ? triangles_within_edges(bundle, leaf, place, has_intercepts, met) : 0;
}

static MLRT_NOINLINE uint32_t packet_triangles_met(const struct mlrt_bundle *bundle,
                                                   const struct mlrt_bundle_leaf *leaf, uint32_t place, uint32_t seen)
{
    return bundle->has.intercepts ? packet_triangles_met_by(bundle, leaf, place, 1, seen)
                                  : packet_triangles_met_by(bundle, leaf, place, 0, seen);
}

#endif
