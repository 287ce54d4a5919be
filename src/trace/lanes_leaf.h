/* SPDX-License-Identifier: MIT */
/*
 * The lanes of a packet against the triangles of a leaf: either each triangle against all lanes at once, or each lane
 * against all triangles at once. But if all rays start at one point, the triangles are set up for that point, and each
 * is tested against all lanes. Before, triangles whose boxes the hull of all lanes misses are left out.
 *
 * TRIANGLES. The arithmetic and its bounds are those of triangle_test.h, with the greatest |d_k| of all lanes for m.
 *
 * OUT OF REACH. Let rays of one origin end at T at the latest, and let s be the sign of N. Then none of them hits the
 * triangle if |N| > T max(0, s D) for all of them: either s D <= 0, so the ray never comes to the plane, or t = |N| /
 * (s D) > T. The greatest s D is the sum of the greater products of s n_k with the ends of the interval of all d_k.
 * Roundings are monotone, so this is the D, as computed, of a direction whose components are such ends and at most m:
 * it has the 7 roundings of D, and the bounds of N and D serve, as in compare_distances. If a product overflows, so
 * does 4 m G H in the bound of D, and the comparison is false.
 */
#ifndef MLRT_TRACE_LANES_LEAF_H
#define MLRT_TRACE_LANES_LEAF_H

#include "base/counters.h"
#include "hits/outcome.h"
#include "hits/triangle_filter.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/lanes_boxes.h"
#include "trace/single_ray_leaf.h"
#include "trace/triangle_test.h"

/* The terms of triangles for rays of one origin: products of these vectors with a direction are e_ca, -e_ab and D. */
struct triangles_from_origin {
    MLRT_ALIGNED(64) float ca[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float ab[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float normal[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float distance[MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float edge_bound[MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float plane_bound[MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float distance_bound[MLRT_BVH_LEAF_LIMIT];
};

MLRT_INLINE void store_cross_product(const vf cross[3], uint32_t v, float (*rows)[MLRT_BVH_LEAF_LIMIT])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) v_store(rows[k] + v, cross[k]);
}

/*
 * The triangles of a vector whose planes no ray reaches up to `farthest`: see "OUT OF REACH" above. `test` has N and
 * the bounds of N and D.
 */
MLRT_INLINE uint32_t planes_out_of_reach(const struct lanes_hull *hull, const struct triangles_from_origin *terms,
                                         uint32_t v, const struct float_test *test, float farthest)
{
    vf toward = v_set1(0);
    for (int k = 0; k < 3; ++k) {
        const vf n = v_flip(v_load(terms->normal[k] + v), test->distance);
        toward = v_add(v_max(v_mul(n, v_set1(hull->direction_lo[k])), v_mul(n, v_set1(hull->direction_hi[k]))), toward);
    }
    const vf greatest_d = v_max(v_set1(0), v_add(toward, test->plane_bound)); /* a NaN remains */
    const vf least_n = v_sub(v_abs(test->distance), test->distance_bound);
    return m_bits(v_gt(least_n, v_mul(greatest_d, v_set1(farthest))));
}

/*
 * Sets the terms of the triangles of a leaf, by triangle_test.h, "ONE ORIGIN". Returns those whose planes rays may
 * reach.
 */
MLRT_INLINE uint32_t set_up_from_origin(const struct lanes_search *search, const float *corners, uint32_t row,
                                        float farthest, struct triangles_from_origin *terms)
{
    uint32_t beyond = 0;
    for (uint32_t v = 0; v < row; v += VW) {
        vf term[SIDE_TERMS], to[3], cross[3];
        struct float_test test;
        set_sides(corners + v, row, term);
        set_side_sizes(search->direction_limit, term);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) to[k] = v_sub(term[k], v_set1(search->origin[k]));
        set_edge_bound(term, to, &test);
        set_plane(term, to, &test);
        v_store(terms->edge_bound + v, test.edge_bound);
        v_store(terms->plane_bound + v, test.plane_bound);
        v_store(terms->distance_bound + v, test.distance_bound);
        v_store(terms->distance + v, test.distance);
        store_cross_product(&term[SIDE_NORMAL], v, terms->normal);
        cross_product(to, &term[SIDE_CA], cross);
        store_cross_product(cross, v, terms->ca);
        cross_product(to, &term[SIDE_AB], cross);
        store_cross_product(cross, v, terms->ab);
        beyond |= planes_out_of_reach(&search->hull, terms, v, &test, farthest) << v;
    }
    return ~beyond & ((1u << row) - 1);
}

/* Tests a triangle against the lanes of a vector, whose directions are d. Returns the lanes with a nearer hit. */
MLRT_INLINE uint32_t test_triangle_from_origin(const struct mlrt_job *job, const struct triangles_from_origin *terms,
                                               uint32_t place, const vf d[3], uint32_t lanes, uint32_t number, int v,
                                               struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    vf ca[3], ab[3], normal[3];
    struct outcome outcome = {0, 0, 0};
    struct float_test test;
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        ca[k] = v_set1(terms->ca[k][place]);
        ab[k] = v_set1(terms->ab[k][place]);
        normal[k] = v_set1(terms->normal[k][place]);
    }
    test.determinant = dot_product(d, normal);
    test.edge_bound = v_set1(terms->edge_bound[place]);
    test.inner = inside_of_sides(dot_product(d, ca), dot_product(d, ab), test.determinant);
    vm candidates = may_be_inside(&test, m_from_bits(lanes >> v));
    if (!m_bits(candidates)) return 0;
    candidates = m_and(candidates, lanes_to_test(packet, lanes, number, v));
    test.plane_bound = v_set1(terms->plane_bound[place]);
    test.distance = v_set1(terms->distance[place]);
    test.distance_bound = v_set1(terms->distance_bound[place]);
    const struct verdict verdict = compare_distances(&test, candidates, v_load(packet->t_min + v),
                                                     v_load(packet->nearest.lo + v), v_load(packet->nearest.hi + v));
    keep_verdict(&verdict, number, v, packet, &outcome);
    if (MLRT_LIKELY(!outcome.undecided) || MLRT_GUESS) return outcome.nearer;
    return outcome.nearer | decide_scaled_lanes(job, number, outcome.undecided, outcome.inside, packet, worker);
}

/* Tests lanes of one origin against the triangles of a leaf. Returns the lanes with a nearer hit. */
static MLRT_NOINLINE uint32_t test_triangles_from_origin(const struct mlrt_job *job,
                                                         const struct triangles_from_origin *terms,
                                                         const uint32_t *numbers, uint32_t triangles, uint32_t lanes,
                                                         struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t all_changed = 0, tested = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        uint32_t left = lanes & ALL_LANES << v;
        const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                         v_load(packet->direction[2] + v)};
        for (uint32_t some = triangles; some && left; some &= some - 1) {
            const uint32_t i = mlrt_lowest_bit(some);
            if (numbers[i] == MLRT_NONE) break;
            const uint32_t seeing = lanes_that_see(job, worker, packet, numbers[i], left);
            if (!seeing) continue;
            tested |= 1u << i;
            COUNT(&worker->counters, lane_test_count, mlrt_count_bits(seeing));
            const uint32_t changed = test_triangle_from_origin(job, terms, i, d, seeing, numbers[i], v, packet, worker);
            all_changed |= changed;
            if (job->any) left &= ~changed;
        }
    }
    COUNT(&worker->counters, triangle_test_count, mlrt_count_bits(tested));
    return all_changed;
}

/*
 * Decides the lanes of a vector that float leaves undecided for the triangle at `place`, of which some may begin beside
 * it (settle_undecided). Returns all lanes with a nearer hit.
 */
static MLRT_NOINLINE uint32_t settle_starts(const struct mlrt_job *job, const float (*terms)[MLRT_BVH_LEAF_LIMIT],
                                            uint32_t place, uint32_t number, struct outcome outcome, int v,
                                            struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    vf term[SIDE_TERMS], to[3], d[3];
    struct float_test test;
    MLRT_UNROLL
    for (int k = 0; k < SIDE_EDGE_FACTOR; ++k) term[k] = v_set1(terms[k][place]);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        to[k] = v_sub(term[k], v_load(packet->origin[k] + v));
        d[k] = v_load(packet->direction[k] + v);
    }
    set_plane_by_components(term, to, d, &test);
    const vm ahead = may_be_nearer(&test, m_from_bits(outcome.undecided >> v), v_load(packet->t_min + v),
                                   v_load(packet->nearest.hi + v));
    if (!m_bits(ahead)) return outcome.nearer;
    return outcome.nearer | decide_scaled_lanes(job, number, m_bits(ahead) << v, outcome.inside, packet, worker);
}

/* Tests lanes of a vector against the triangle at `place`. Returns the lanes with a nearer hit. */
MLRT_INLINE uint32_t test_triangle_against_lanes(const struct mlrt_job *job, const float (*terms)[MLRT_BVH_LEAF_LIMIT],
                                                 uint32_t place, const vf origin[3], const vf d[3], uint32_t lanes,
                                                 uint32_t number, int v, struct mlrt_packet *packet,
                                                 struct mlrt_worker *worker)
{
    struct outcome outcome = {0, 0, 0};
    struct float_test test;
    vf term[SIDE_TERMS], to[3];
    MLRT_UNROLL
    for (int i = 0; i < SIDE_TERMS; i += 3) {
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) term[i + k] = v_set1(terms[i + k][place]);
    }
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) to[k] = v_sub(term[k], origin[k]);
    set_edges(term, to, d, &test);
    set_edge_bound(term, to, &test);
    set_plane(term, to, &test);
    const vf t_min = v_load(packet->t_min + v);
    const vm inside = may_be_inside(&test, lanes_to_test(packet, lanes, number, v));
    const vm candidates = may_be_nearer(&test, inside, t_min, v_load(packet->nearest.hi + v));
    if (!m_bits(candidates)) return 0; /* one branch, after distances */
    struct verdict verdict = compare_with_nearest_hits(&test, candidates, t_min, v_load(packet->nearest.lo + v));
    if (m_bits(verdict.nearer)) bound_distances(&test, &verdict);
    keep_verdict(&verdict, number, v, packet, &outcome);
    if (MLRT_LIKELY(!outcome.undecided) || MLRT_GUESS) return outcome.nearer;
    if (outcome.undecided & ~(m_bits(surely_begun(&test, t_min)) << v))
        return settle_starts(job, terms, place, number, outcome, v, packet, worker);
    return outcome.nearer | decide_scaled_lanes(job, number, outcome.undecided, outcome.inside, packet, worker);
}

/* Tests each triangle of a leaf against all lanes at once. Returns the lanes with a nearer hit. */
static MLRT_NOINLINE uint32_t test_by_triangles(const struct mlrt_job *job, const float (*terms)[MLRT_BVH_LEAF_LIMIT],
                                                const uint32_t *numbers, uint32_t triangles, uint32_t lanes,
                                                struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t all_changed = 0, tested = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        uint32_t left = lanes & ALL_LANES << v;
        vf origin[3], d[3];
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            origin[k] = v_load(packet->origin[k] + v);
            d[k] = v_load(packet->direction[k] + v);
        }
        for (uint32_t some = triangles; some && left; some &= some - 1) {
            const uint32_t i = mlrt_lowest_bit(some);
            if (numbers[i] == MLRT_NONE) break;
            const uint32_t seeing = lanes_that_see(job, worker, packet, numbers[i], left);
            if (!seeing) continue;
            tested |= 1u << i;
            COUNT(&worker->counters, lane_test_count, mlrt_count_bits(seeing));
            const uint32_t changed =
                test_triangle_against_lanes(job, terms, i, origin, d, seeing, numbers[i], v, packet, worker);
            all_changed |= changed;
            if (job->any) left &= ~changed;
        }
    }
    COUNT(&worker->counters, triangle_test_count, mlrt_count_bits(tested));
    return all_changed;
}

/* The triangles of a leaf whose boxes the hull of all lanes meets; the corners of an odd triangle are NaN. */
MLRT_INLINE uint32_t triangles_in_hull(const struct lanes_hull *hull, const float *corners, uint32_t row,
                                       float farthest)
{
    uint32_t missed = 0;
    for (uint32_t v = 0; v < row; v += VW) {
        struct boxes_in_hull boxes;
        begin_boxes(hull, farthest, &boxes);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            const float *at = corners + (size_t)k * row + v;
            const vf a = v_load_any(at), b = v_load_any(at + 3 * row), c = v_load_any(at + 6 * row);
            cut_boxes(hull, k, v_min(a, v_min(b, c)), v_max(a, v_max(b, c)), &boxes);
        }
        missed |= m_bits(boxes_missed(&boxes)) << v;
    }
    return ~missed & ((1u << row) - 1);
}

/* Tests each lane against all triangles of a part of a leaf at once. Returns those that have a hit, if any will do. */
MLRT_INLINE uint32_t test_by_lanes(const struct mlrt_job *job, uint32_t lanes, const struct leaf_part *part,
                                   float direction_limit, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t all_changed = 0;
    vf term[SIDE_TERMS];
    set_sides(part->corners, part->row, term);
    set_side_sizes(direction_limit, term);
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        const vf t_min = v_set1(packet->t_min[lane]);
        struct corner_rows nearest = {NULL, 0};
        struct float_test test;
        vf to[3], d[3];
        MLRT_UNROLL
        for (uint32_t k = 0; k < 3; ++k) {
            to[k] = v_sub(term[k], v_set1(packet->origin[k][lane]));
            d[k] = v_set1(packet->direction[k][lane]);
        }
        set_edges(term, to, d, &test);
        if (test_leaf_part(job, job->any, part, term, to, t_min, lane, &nearest, &test, packet, worker)) {
            all_changed |= 1u << lane;
        }
    }
    return all_changed;
}

/* Tests lanes against the triangles of a leaf, in the way that takes the fewest steps. */
static MLRT_NOINLINE void test_leaf_against_lanes(const struct mlrt_job *job, uint32_t leaf, uint32_t lanes,
                                                  struct lanes_search *search, struct mlrt_packet *packet,
                                                  struct mlrt_worker *worker)
{
    const struct mlrt_bvh *bvh = &job->tree->bvh;
    const uint32_t row = 4 * mlrt_bvh_quad_count(leaf);
    const float *corners = bvh->corners + (size_t)36 * mlrt_bvh_offset(leaf);
    const uint32_t *numbers = bvh->numbers + (size_t)4 * mlrt_bvh_offset(leaf);
    const uint32_t lane_count = mlrt_count_bits(lanes);
    uint32_t triangles = (1u << row) - 1;
    if (lane_count > FEW_FOR_HULL && search->hull.is_narrow) {
        triangles = triangles_in_hull(&search->hull, corners, row, last_end(&search->hull, packet, lanes, job->any));
        if (!triangles) return;
    }
    if (search->one_origin && lane_count > FEW_LANES) {
        struct triangles_from_origin terms;
        const uint32_t reached = triangles & set_up_from_origin(search, corners, row, search->hull.farthest, &terms);
        if (!reached) return;
        const uint32_t changed = test_triangles_from_origin(job, &terms, numbers, reached, lanes, packet, worker);
        if (job->any) search->alive &= ~changed;
        return;
    }
    if (lane_count < mlrt_count_bits(triangles)) {
        COUNT(&worker->counters, packet_count, lane_count); /* each goes alone */
        for (uint32_t v = 0; v < row && lanes; v += VW) {
            const struct leaf_part part = {corners + v, numbers + v, row, triangles >> v};
            if (!(part.places & ALL_LANES)) continue;
            const uint32_t changed = test_by_lanes(job, lanes, &part, search->direction_limit, packet, worker);
            if (!job->any) continue;
            lanes &= ~changed;
            search->alive &= ~changed;
        }
        return;
    }
    MLRT_ALIGNED(64) float terms[SIDE_TERMS][MLRT_BVH_LEAF_LIMIT];
    for (uint32_t v = 0; v < row; v += VW) {
        vf term[SIDE_TERMS];
        set_sides(corners + v, row, term);
        set_side_sizes(search->direction_limit, term);
        MLRT_UNROLL
        for (int i = 0; i < SIDE_TERMS; i += 3) {
            MLRT_UNROLL
            for (int k = 0; k < 3; ++k) v_store(terms[i + k] + v, term[i + k]);
        }
    }
    const uint32_t changed =
        test_by_triangles(job, (const float(*)[MLRT_BVH_LEAF_LIMIT])terms, numbers, triangles, lanes, packet, worker);
    if (job->any) search->alive &= ~changed;
}

#endif
