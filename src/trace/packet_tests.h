/* SPDX-License-Identifier: MIT */
/*
 * Tests of a packet's rays against the triangles of a leaf: edge functions first, then distances. leaf.h derives their
 * bounds.
 */
#ifndef MLRT_TRACE_PACKET_TESTS_H
#define MLRT_TRACE_PACKET_TESTS_H

#include <math.h>

#include "base/counters.h"
#include "hits/triangle_filter.h"
#include "rays/slope_limits.h"
#include "scene/masks.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/hull_triangles.h"
#include "trace/leaf.h"
#include "trace/nearest_hits.h"
#include "trace/settle_leaf.h"

#define PACKET_VECTORS (MLRT_PACKET_RAYS / VW)

/* Of each triangle and each ray of a packet, how far the ray passes inside of the edges (inside_of_edges). */
struct edge_values {
    MLRT_ALIGNED(64) float inner[MLRT_BVH_LEAF_LIMIT][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float bound[MLRT_BVH_LEAF_LIMIT]; /* error bounds; without intercepts [0] is that of all */
    uint32_t of_vector[PACKET_VECTORS];                /* of each vector of rays: the triangles that may be hit */
};

/*
 * Finds the edge values of `count` vectors of rays, from the vector `first` on. This loop has no branch that depends
 * on a triangle's result, and keeps only terms in registers. Most triangles have no ray inside and end here, and so do
 * those that all such rays skip: rays to a light mostly end on one.
 */
MLRT_INLINE void find_edge_values(const struct mlrt_bundle_leaf *leaf, const struct mlrt_bundle_rays *rays,
                                  const struct mlrt_packet *packet, uint32_t triangles, int has_intercepts, int first,
                                  int count, struct edge_values *of)
{
    const int term_count = has_intercepts ? MLRT_RAY_TERMS : 2;
    vf term[PACKET_VECTORS][MLRT_RAY_TERMS], bound = v_set1(of->bound[0]);
    vi skip[PACKET_VECTORS];
    uint32_t met[PACKET_VECTORS] = {0};
    MLRT_UNROLL
    for (int n = 0; n < count; ++n) {
        const int v = VW * (first + n);
        skip[n] = packet->has.skip ? i_load(packet->skip + v) : i_set1(MLRT_NONE);
        const vm lanes = m_from_bits(packet->active >> v);
        MLRT_UNROLL
        for (int i = 0; i < term_count; ++i) term[n][i] = v_select(lanes, v_load(rays->term[i] + v), v_set1(NAN));
    }
    for (; triangles; triangles &= triangles - 1) {
        const uint32_t triangle = mlrt_lowest_bit(triangles), bit = triangles & (0u - triangles);
        vf least[PACKET_VECTORS], greatest[PACKET_VECTORS];
        MLRT_UNROLL
        for (int edge = 0; edge < 3; ++edge) {
            vf e[PACKET_VECTORS];
            MLRT_UNROLL
            for (int n = 0; n < count; ++n) e[n] = v_set1(leaf->edges.constant[edge][triangle]);
            MLRT_UNROLL
            for (int i = 0; i < term_count; ++i) {
                const vf c = v_set1(leaf->edges.coefficient[edge][i][triangle]);
                MLRT_UNROLL
                for (int n = 0; n < count; ++n) e[n] = v_mul_add(c, term[n][i], e[n]);
            }
            MLRT_UNROLL
            for (int n = 0; n < count; ++n) {
                least[n] = edge ? v_min(e[n], least[n]) : e[n];
                if (has_intercepts) greatest[n] = edge ? v_max(e[n], greatest[n]) : e[n];
            }
        }
        if (has_intercepts) bound = v_set1(of->bound[triangle]);
        MLRT_UNROLL
        for (int n = 0; n < count; ++n) {
            const int v = VW * (first + n);
            const vf inner = has_intercepts ? v_max(least[n], v_opposite(greatest[n])) : least[n];
            v_store(of->inner[triangle] + v, inner);
            /* Lanes that are not active have NaN, of which no comparison is true. */
            const vm may = m_andnot(v_ge(inner, v_opposite(bound)), i_eq(skip[n], i_set1(leaf->numbers[triangle])));
            met[n] |= m_bits(may) ? bit : 0;
        }
    }
    MLRT_UNROLL
    for (int n = 0; n < count; ++n) of->of_vector[first + n] = met[n];
}

/* A vector of a packet's rays while it is tested against the triangles of a leaf. */
struct bundle_vector {
    vf slope[2];
    vf to_waist[3];
    struct nearest_hits nearest;
};

/* Error bounds of D and N that hold for all rays of a packet and all triangles. */
struct plane_bounds {
    vf width;   /* 16 u R: of D */
    float away; /* A: that of N is DISTANCE_ERROR (F + A) */
    int has_begins;
};

/*
 * Compares the distances of a triangle with those of the nearest hits, for a vector of rays of which `candidates` may
 * be inside the edges and `inside` surely are. Makes it the nearest hit where that is certain. Returns the lanes that
 * are undecided.
 */
MLRT_INLINE uint32_t test_distances(const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                                    const struct plane_bounds *bounds, const float *begin, int has_intercepts,
                                    vm candidates, vm inside, struct bundle_vector *of, struct plane_of_rays *plane)
{
    vf n = v_set1(leaf->planes.distance[triangle]), d = v_set1(leaf->planes.normal[0][triangle]);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) d = v_mul_add(v_set1(leaf->planes.normal[1 + i][triangle]), of->slope[i], d);
    if (has_intercepts) {
        MLRT_UNROLL
        for (int i = 0; i < 3; ++i) n = v_mul_add(v_set1(leaf->planes.normal[i][triangle]), of->to_waist[i], n);
    }
    const float error = DISTANCE_ERROR * (leaf->planes.away[triangle] + bounds->away) + DISTANCE_FLOOR;
    const vf size = has_intercepts ? v_abs(d) : d, distance = has_intercepts ? v_flip(n, d) : n, width = bounds->width;
    plane->least_d = v_sub(size, width);
    plane->greatest_d = v_add(size, width);
    plane->least_n = v_sub(distance, v_set1(error));
    plane->greatest_n = v_add(distance, v_set1(error));
    plane->certain = m_and(candidates, v_gt(plane->least_d, width));
    plane->backward = v_lt(d, v_set1(0));
    vm farther, nearer;
    compare_planes(plane, &of->nearest, &farther, &nearer);
    if (MLRT_UNLIKELY(bounds->has_begins)) {
        const vf from = v_load(begin);
        farther = m_or(farther, v_lt(plane->greatest_n, v_mul(v_mul(from, v_set1(1 - SLOPE_SLACK)), plane->least_d)));
        plane->begun = v_gt(plane->least_n, v_mul(v_mul(from, v_set1(1 + SLOPE_SLACK)), plane->greatest_d));
    } else {
        if (has_intercepts) farther = m_or(farther, v_lt(plane->greatest_n, v_set1(0))); /* from the waist, N >= 0 */
        plane->begun = v_gt(plane->least_n, v_set1(0));
    }
    vm hit = m_and(m_and(plane->certain, inside), m_and(nearer, plane->begun));
    vm open = m_andnot(m_andnot(candidates, m_and(plane->certain, farther)), hit);
    if (!has_intercepts) open = m_andnot(open, v_lt(plane->greatest_d, v_set1(0)));
    uint32_t undecided = m_bits(open);
    if (MLRT_GUESS) hit = m_and(m_and(candidates, m_and(nearer, plane->begun)), v_gt(size, v_set1(0))), undecided = 0;
    keep_plane(plane, leaf->numbers[triangle], hit, &of->nearest);
    return undecided;
}

/* Tests a vector of a packet's rays against triangles, given their edge values. Returns the lanes with a new hit. */
MLRT_INLINE uint32_t test_bundle_vector(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                        const struct edge_values *edges, uint32_t place, int has_intercepts, int v)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const struct plane_bounds bounds = {v_set1(PLANE_BOUND * hulls->filter.direction_size[place]),
                                        has_intercepts ? hulls->filter.away[place] : 0, bundle->has.begins};
    const vi skip = packet->has.skip ? i_load(packet->skip + v) : i_set1(MLRT_NONE);
    uint32_t decided = 0, close_count = 0;
    vf bound = v_set1(edges->bound[0]);
    struct bundle_vector of;
    struct close_triangle_of_leaf close[MLRT_BVH_LEAF_LIMIT];
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) of.slope[i] = v_load(rays->term[i] + v);
    MLRT_UNROLL
    for (int i = 0; i < 3; ++i) of.to_waist[i] = has_intercepts ? v_load(rays->to_waist[i] + v) : v_set1(0);
    load_nearest_hits(rays, packet, v, &of.nearest);
    for (uint32_t met = edges->of_vector[v / VW]; met; met &= met - 1) {
        const uint32_t triangle = mlrt_lowest_bit(met), number = leaf->numbers[triangle];
        if (has_intercepts) bound = v_set1(edges->bound[triangle]);
        const vf inner = v_load(edges->inner[triangle] + v);
        const vm inside = v_gt(inner, bound);
        const vm known = m_or(i_eq(of.nearest.triangle, i_set1(number)), i_eq(skip, i_set1(number)));
        vm may = m_andnot(v_ge(inner, v_opposite(bound)), known);
        if (job->any) may = m_and(may, i_eq(of.nearest.triangle, i_set1(MLRT_NONE)));
        if (MLRT_UNLIKELY(packet->has.masks)) {
            may = m_from_bits(mlrt_seeing_lanes(job->tree, number, packet->mask, m_bits(may) << v) >> v);
        }
        struct plane_of_rays plane;
        const uint32_t undecided =
            test_distances(leaf, triangle, &bounds, rays->begin + v, has_intercepts, may, inside, &of, &plane);
        if (MLRT_LIKELY(!undecided)) continue;
        if (job->tree->bvh.places) mlrt_prefetch(&job->tree->bvh.places[number]); /* for settle_leaf */
        close[close_count++] = (struct close_triangle_of_leaf){plane, inside, undecided, triangle};
    }
    if (MLRT_UNLIKELY(close_count != 0)) {
        struct nearest_hits now = of.nearest; /* a copy, so that the original can stay in registers */
        decided = settle_leaf(job, worker, bundle, leaf, place, close, close_count, v, &now);
        of.nearest = now;
    }
    return decided | store_nearest_hits(&of.nearest, v, rays, packet);
}

/* Vectors of rays from anywhere whose edge values are found at once: for more there are not enough registers. */
#define VECTORS_FROM_ANYWHERE (PACKET_VECTORS < 2 ? PACKET_VECTORS : 2)

/* Tests a packet against triangles of a leaf, and counts those that no ray can hit. Returns lanes with a new hit. */
MLRT_INLINE uint32_t test_bundle_packet(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                        uint32_t triangles, uint32_t place, int has_intercepts)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct edge_values edges;
    uint32_t changed = 0, met = 0;
    COUNT(&worker->counters, triangle_test_count, mlrt_count_bits(triangles));
    COUNT(&worker->counters, lane_test_count, mlrt_count_bits(triangles) * mlrt_count_bits(packet->active));
    for (uint32_t v = 0; v < (has_intercepts ? MLRT_BVH_LEAF_LIMIT : 1); v += VW) {
        v_store(edges.bound + v,
                edge_bounds(&(struct hull_pairs){&bundle->hulls, leaf, place, v, 0, has_intercepts}, 1));
    }
    if (has_intercepts) {
        for (int first = 0; first < PACKET_VECTORS; first += VECTORS_FROM_ANYWHERE) {
            find_edge_values(leaf, rays, packet, triangles, 1, first, VECTORS_FROM_ANYWHERE, &edges);
        }
    } else {
        find_edge_values(leaf, rays, packet, triangles, 0, 0, PACKET_VECTORS, &edges);
    }
    for (int n = 0; n < PACKET_VECTORS; ++n) {
        met |= edges.of_vector[n];
        if (edges.of_vector[n])
            changed |= test_bundle_vector(job, worker, bundle, leaf, &edges, place, has_intercepts, VW * n);
    }
    bundle->state.tests[place] += mlrt_count_bits(triangles & ~met);
    return changed;
}

#endif
