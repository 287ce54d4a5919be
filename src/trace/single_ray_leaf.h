/* SPDX-License-Identifier: MIT */
/*
 * One ray against the triangles of a leaf, a vector of them at a time. The arithmetic and its bounds are those of
 * triangle_test.h. What it leaves open is decided in double, and by the judge where double cannot tell.
 */
#ifndef MLRT_TRACE_SINGLE_RAY_LEAF_H
#define MLRT_TRACE_SINGLE_RAY_LEAF_H

#include <stddef.h>

#include "base/counters.h"
#include "exact/order.h"
#include "exact/triangle.h"
#include "hits/triangle_filter.h"
#include "hits/undecided.h"
#include "scene/masks.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/single_ray_boxes.h"
#include "trace/triangle_test.h"
#include "trace/units.h"

/*
 * Makes the nearest of the triangles in `nearer`, which are surely hit between lo[i] and hi[i], the nearest hit of the
 * lane, and sets *place to its place. Returns those whose distances overlap with it, which have to be compared exactly.
 */
MLRT_INLINE uint32_t keep_nearest(const float *lo, const float *hi, uint32_t nearer, const uint32_t *numbers,
                                  uint32_t lane, struct mlrt_packet *packet, uint32_t *place)
{
    uint32_t close = 0, nearest = mlrt_lowest_bit(nearer);
    for (uint32_t left = nearer & (nearer - 1); left; left &= left - 1) {
        const uint32_t i = mlrt_lowest_bit(left);
        if (hi[i] < hi[nearest]) nearest = i;
    }
    packet->nearest.triangle[lane] = numbers[nearest];
    packet->nearest.lo[lane] = lo[nearest];
    packet->nearest.hi[lane] = hi[nearest];
    *place = nearest;
    for (nearer &= ~(1u << nearest); nearer; nearer &= nearer - 1) {
        const uint32_t i = mlrt_lowest_bit(nearer);
        if (!MLRT_GUESS && lo[i] <= hi[nearest]) close |= 1u << i;
    }
    return close;
}

/*
 * The places that need no test: empty ones, the nearest hit so far (a triangle can be in several leaves), and the
 * triangle that the ray skips.
 */
MLRT_INLINE vm places_without_test(const struct mlrt_packet *packet, uint32_t lane, vi number)
{
    const vm ignored = m_or(i_eq(number, i_set1(MLRT_NONE)), i_eq(number, i_set1(packet->nearest.triangle[lane])));
    return packet->has.skip ? m_or(ignored, i_eq(number, i_set1(packet->skip[lane]))) : ignored;
}

/*
 * Where the corners of a triangle lie: coordinate i is corner[i * row]. As struct mlrt_corners, but of two words that a
 * ray reads as they were written: halves that are written by themselves and read together cost it 4 to 7 %.
 */
struct corner_rows {
    const float *corner;
    size_t row;
};

/* Triangles of a leaf, as many as a vector holds. Coordinate i of the corners of triangle p is corners[i * row + p]. */
struct leaf_part {
    const float *corners;
    const uint32_t *numbers;
    uint32_t row;
    uint32_t places; /* a bit for each triangle; bits of places behind the part do no harm */
};

/*
 * What float leaves undecided for a lane in a part of a leaf: `undecided` has a bit for each such place. The ray surely
 * passes inside the edges of those in `inside`. Of these, it surely meets those in `hit` behind t_min, at lo[i] or
 * farther. Where any hit will do, `lo` is NULL.
 */
struct open_places {
    uint32_t undecided;
    uint32_t inside;
    uint32_t hit;
    const float *lo;
};

/* The place of triangle `number`, which is among `numbers`. */
MLRT_INLINE uint32_t find_place(const uint32_t *numbers, uint32_t number)
{
    uint32_t place = 0;
    while (numbers[place] != number) ++place;
    return place;
}

/*
 * Compares the triangles `hit` of a part, which a lane surely hits, with its nearest hit. Returns those that double
 * does not order. The nearer of the two becomes the nearest hit, without a branch. Its bounds do not depend on which it
 * is (settle_undecided), so traversal goes on before the order is known. Rays and corners in units are exact, and
 * powers of two change no order.
 */
MLRT_INLINE uint32_t order_places(const struct mlrt_job *job, const struct leaf_part *part, uint32_t hit, uint32_t lane,
                                  struct corner_rows *nearest, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct ray_rows rows = rows_of_tested_ray(packet, lane, worker);
    const struct two_vectors origin = load_twice(rows.origin, rows.origin_step),
                             direction = load_twice(rows.direction, rows.step);
    uint32_t left = 0;
    for (; hit; hit &= hit - 1) {
        const uint32_t i = mlrt_lowest_bit(hit), other = packet->nearest.triangle[lane];
        if (!nearest->corner) {
            const struct mlrt_corners found = mlrt_corners_of(&job->tree->by_number, other);
            if (MLRT_UNLIKELY(!found.in_units) && job->tree->bvh.unit != 1) return left | hit; /* an odd triangle */
            *nearest = (struct corner_rows){found.corner, found.row};
        }
        const struct mlrt_corners first = {part->corners + i, part->row, 1};
        const struct mlrt_corners second = {nearest->corner, (uint32_t)nearest->row, 1};
        const uint32_t number = part->numbers[i];
        const int wins_tie = number < other;
        int is_first = comes_first(origin, direction, &first, &second, wins_tie), is_tie = 0;
        if (MLRT_UNLIKELY(is_first < 0)) {
            is_tie = !worker->lone && mlrt_known_plane_of(worker, number) == mlrt_known_plane_of(worker, other);
            if (!is_tie) {
                left |= 1u << i;
                continue;
            }
            is_first = wins_tie;
        }
        COUNT(&worker->counters, tie_lane_count, (uint32_t)is_tie);
        COUNT(&worker->counters, undecided_test_count, !is_tie);
        COUNT(&worker->counters, judged_lane_count, !is_tie);
        const uint32_t take = 0u - (uint32_t)is_first;
        packet->nearest.triangle[lane] = (number & take) | (other & ~take);
        nearest->corner = is_first ? first.corner : nearest->corner;
        nearest->row = is_first ? first.row : nearest->row;
    }
    return left;
}

/*
 * The places of a part whose triangles a lane may meet between t_min and its nearest hit, by triangle_test.h, "BY
 * COMPONENTS".
 */
static MLRT_NOINLINE uint32_t places_ahead(const struct leaf_part *part, uint32_t lane,
                                           const struct mlrt_packet *packet, const struct mlrt_worker *worker)
{
    vf term[SIDE_TERMS], to[3], d[3];
    const struct ray_rows rows = rows_of_tested_ray(packet, lane, worker);
    struct float_test test;
    set_sides(part->corners, part->row, term);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        to[k] = v_sub(term[k], v_set1(rows.origin[k * rows.origin_step]));
        d[k] = v_set1(rows.direction[k * rows.step]);
    }
    set_plane_by_components(term, to, d, &test);
    return m_bits(
        may_be_nearer(&test, m_from_bits(ALL_LANES), v_set1(packet->t_min[lane]), v_set1(packet->nearest.hi[lane])));
}

/*
 * Decides the triangles of a part that float leaves undecided. `nearest`: where the corners of the nearest hit so far
 * lie, if that is known. Returns where they lie afterwards.
 *
 * Most rays that leave a surface begin one float beside it, and are undecided for the triangles of its plane. Float
 * tells by components that they leave them.
 *
 * If a triangle is surely hit, so that only its order with the nearest hit is in question, let t be the lesser of both
 * distances. It is at most that of the nearest hit so far, whose `hi` therefore stays, and not less than the lesser of
 * both lower bounds, which becomes `lo`.
 */
static MLRT_NOINLINE struct corner_rows settle_undecided(const struct mlrt_job *job, const struct leaf_part *part,
                                                         const struct open_places *open, uint32_t lane,
                                                         struct corner_rows nearest, struct mlrt_packet *packet,
                                                         struct mlrt_worker *worker)
{
    const uint32_t hit = open->hit & open->undecided;
    uint32_t undecided = open->undecided;
    if (undecided & ~hit) {
        undecided &= hit | places_ahead(part, lane, packet, worker);
        if (!undecided) return nearest;
    }
    if (hit && packet->nearest.triangle[lane] != MLRT_NONE) {
        float least = packet->nearest.lo[lane];
        for (uint32_t left = hit; left; left &= left - 1) {
            const float x = open->lo[mlrt_lowest_bit(left)];
            least = x < least ? x : least;
        }
        packet->nearest.lo[lane] = least;
        undecided &= ~hit | order_places(job, part, hit, lane, &nearest, packet, worker);
        if (MLRT_LIKELY(!undecided)) return nearest;
    }
    const uint32_t before = packet->nearest.triangle[lane];
    decide_scaled_triangles(job, part->numbers, undecided, open->inside, lane, packet, worker);
    const uint32_t after = packet->nearest.triangle[lane];
    if (after == before) return nearest;
    return (struct corner_rows){part->corners + find_place(part->numbers, after), part->row};
}

/*
 * Tests the triangles of a part of a leaf for a lane, given edge functions and D in *test, of which it sets the rest.
 * `to` goes from the origin to corners a. Sets *nearest if the nearest hit changes. Returns 1 if any will do, and one
 * was found.
 */
MLRT_INLINE int test_leaf_part(const struct mlrt_job *job, int any, const struct leaf_part *part,
                               const vf term[SIDE_TERMS], const vf to[3], vf t_min, uint32_t lane,
                               struct corner_rows *nearest, struct float_test *test, struct mlrt_packet *packet,
                               struct mlrt_worker *worker)
{
    set_edge_bound(term, to, test);
    const vm inside = may_be_inside(test, m_from_bits(ALL_LANES));
    if (VW <= 4 && !m_bits(inside)) return 0; /* wide vectors take one branch, after distances */
    set_plane(term, to, test);
    const vm ignored = places_without_test(packet, lane, i_load_any(part->numbers));
    const vm left = may_be_nearer(test, m_andnot(inside, ignored), t_min, v_set1(packet->nearest.hi[lane]));
    uint32_t candidates = m_bits(left) & part->places;
    if (!candidates) return 0;
    struct verdict verdict = compare_with_nearest_hits(test, left, t_min, v_set1(packet->nearest.lo[lane]));
    if (MLRT_GUESS) candidates &= m_bits(verdict.nearer);
    const uint32_t mask = packet->has.masks ? packet->mask[lane] : worker->mask;
    if (MLRT_UNLIKELY(mask != MLRT_MASK_ALL)) {
        candidates = mlrt_visible_places(job->tree, part->numbers, candidates, mask);
    }
    uint32_t undecided = MLRT_GUESS ? 0 : m_bits(verdict.undecided) & candidates;
    const uint32_t nearer = m_bits(verdict.nearer) & candidates;
    if (nearer && any) {
        const uint32_t place = mlrt_lowest_bit(nearer);
        packet->nearest.triangle[lane] = part->numbers[place];
        *nearest = (struct corner_rows){part->corners + place, part->row};
        return 1;
    }
    if (!(nearer | undecided)) return 0;
    const uint32_t hit = m_bits(m_and(verdict.inside, surely_begun(test, t_min)));
    MLRT_ALIGNED(64) float lo[VW];
    MLRT_ALIGNED(64) float greatest[VW];
    if (!any) {
        bound_distances(test, &verdict);
        v_store(lo, verdict.lo);
        v_store(greatest, verdict.hi);
    }
    if (!any && nearer) {
        uint32_t place;
        undecided |= keep_nearest(lo, greatest, nearer, part->numbers, lane, packet, &place);
        *nearest = (struct corner_rows){part->corners + place, part->row};
    }
    if (MLRT_UNLIKELY(undecided)) {
        const struct leaf_part here = *part; /* a copy: the part itself may stay in registers */
        const struct open_places open = {undecided, m_bits(verdict.inside), hit, any ? NULL : lo};
        *nearest = settle_undecided(job, &here, &open, lane, *nearest, packet, worker);
        return any && packet->nearest.triangle[lane] != MLRT_NONE;
    }
    return 0;
}

/* Counts the tests of a lane and the triangles of a leaf that it sees, in kernels that count. */
MLRT_INLINE void count_leaf_tests(const struct mlrt_job *job, const uint32_t *numbers, uint32_t place_count,
                                  const struct mlrt_packet *packet, uint32_t lane, struct mlrt_worker *worker)
{
    if (!MLRT_COUNTING) return;
    const uint32_t mask = packet->has.masks ? packet->mask[lane] : worker->mask;
    uint32_t count = place_count;
    while (numbers[count - 1] == MLRT_NONE) --count;
    if (MLRT_UNLIKELY(mask != MLRT_MASK_ALL)) {
        count = mlrt_count_bits(mlrt_visible_places(job->tree, numbers, (1u << count) - 1, mask));
    }
    COUNT(&worker->counters, triangle_test_count, count);
    COUNT(&worker->counters, lane_test_count, count);
}

/* Tests the triangles of a leaf. Sets *nearest if the nearest hit changes. Returns 1 if a query for any hit has one. */
MLRT_INLINE int test_leaf(const struct mlrt_job *job, int any, const struct single_ray *ray, uint32_t leaf,
                          struct corner_rows *nearest, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct mlrt_bvh *bvh = &job->tree->bvh;
    const uint32_t place_count = 4 * mlrt_bvh_quad_count(leaf);
    struct leaf_part part = {bvh->corners + (size_t)36 * mlrt_bvh_offset(leaf),
                             bvh->numbers + (size_t)4 * mlrt_bvh_offset(leaf), place_count, (1u << place_count) - 1};
    count_leaf_tests(job, part.numbers, place_count, packet, ray->lane, worker);
    for (;;) {
        vf term[SIDE_TERMS], to[3];
        struct float_test test;
        set_sides(part.corners, place_count, term);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) to[k] = v_sub(term[k], ray->origin[k]);
        set_edges(term, to, ray->direction, &test);
        set_side_sizes(ray->direction_limit, term);
        if (test_leaf_part(job, any, &part, term, to, ray->t_min, ray->lane, nearest, &test, packet, worker)) return 1;
        part.places >>= VW;
        if (VW == MLRT_BVH_LEAF_LIMIT || !part.places) return 0;
        part.corners += VW;
        part.numbers += VW;
    }
}

#endif
