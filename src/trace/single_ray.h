/* SPDX-License-Identifier: MIT */
/*
 * One ray at a time down the hierarchy of boxes, for rays that have nothing in common. A vector holds the boxes of a
 * node, or the triangles of a leaf. Of the children that the ray meets, the nearest is visited first (with a query for
 * any hit: the one that is most likely to have a hit). The others wait on a stack, and are dropped if they begin behind
 * the nearest hit so far.
 *
 * BOXES. A ray is in a slab between t_near and t_far. Each is x r, with x = c - o for the plane at c, and r = 1 / d.
 * (The code has both factors with the opposite sign.) As computed, x and r have one rounding each; r is multiplied by
 * 1 -+ RECIPROCAL_SLACK (8 u), which is one rounding more. So before the product is rounded, t_near is surely too small
 * and t_far surely too large if they are positive. (A t_near that is not positive does not matter; a t_far that is
 * negative says rightly that the box is behind.) The rounding of the product is monotone, and t_min and the `hi` of the
 * nearest hit are floats: so where t_near <= t_far, t_near <= hi and t_min <= t_far are true, they remain true, even
 * with underflow. So a box is left out only if the ray surely passes it, or surely enters it behind `hi`.
 *
 * If d_k = 0, r is infinite. Then t_near is -inf and t_far inf if the origin is inside the slab; both are inf, or both
 * -inf, if it is outside; if it is on a plane of the slab, one is a NaN, which v_min and v_max drop because it is their
 * first operand. Distances beyond FLT_MAX are no hits (triangle_filter.h: t <= 2^121), so rays end there, and a box
 * with t_near = inf is left out. An empty slot is such a box, since its lo is inf and its hi -inf: so the slots in use
 * need not be counted.
 *
 * TRIANGLES. The arithmetic and its bounds are those of triangle_test.h.
 *
 * Based on: I. Wald et al., "Getting Rid of Packets", 2008 (one ray, wide nodes).
 */
#ifndef MLRT_TRACE_SINGLE_RAY_H
#define MLRT_TRACE_SINGLE_RAY_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/counters.h"
#include "exact/order.h"
#include "exact/triangle.h"
#include "hits/triangle_filter.h"
#include "hits/undecided.h"
#include "rays/extremes.h"
#include "scene/masks.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/triangle_test.h"
#include "trace/units.h"

/*
 * A stack entry has a child in its lower half, and in its upper half the bits of the distance at which the ray enters
 * it: floats that are not negative are in order as integers. All entries of one level of the tree are children of one
 * node, which has visited at least one of its children.
 */
#define WAITING_LIMIT ((MLRT_BVH_WIDTH - 1) * MLRT_BVH_DEPTH_LIMIT + 1)

/* Bytes from the start of a node to the lower, or upper, planes of its boxes along axis k. */
MLRT_INLINE uint32_t row_of_planes(uint32_t is_upper, uint32_t k)
{
    return (3 * is_upper + k) * (uint32_t)sizeof(float[MLRT_BVH_WIDTH]);
}

struct single_ray {
    vf origin[3];
    vf direction[3];
    vf near[3]; /* -1 / d, moved toward 0 */
    vf far[3];  /* -1 / d, moved away from 0 */
    vf t_min;
    size_t near_row[3]; /* per axis, the offset in a node of the planes that the ray crosses first */
    size_t far_row[3];  /* of those that it crosses last */
    float reach;        /* 4 m: see "Overflow" in triangle_test.h */
    uint32_t lane;
};

MLRT_INLINE void set_reciprocals(const struct mlrt_packet *packet, struct mlrt_reciprocals *reciprocals)
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            v_store(reciprocals->rounded[k] + v, v_div(v_set1(1), v_load(packet->direction[k] + v)));
        }
    }
}

/* Where the numbers of a ray lie: those of one vector are `step` floats apart. */
struct ray_rows {
    const float *origin;
    const float *direction;
    const float *reciprocal; /* 1 / d, rounded */
    size_t origin_step;
    size_t step;
};

/* Finds the numbers of a lane of a packet; without reciprocals if `reciprocals` is null. */
MLRT_INLINE struct ray_rows rows_of_lane(const struct mlrt_packet *packet, const struct mlrt_reciprocals *reciprocals,
                                         uint32_t lane)
{
    return (struct ray_rows){packet->has.apex ? packet->apex : packet->origin[0] + lane, packet->direction[0] + lane,
                             reciprocals ? reciprocals->rounded[0] + lane : NULL,
                             packet->has.apex ? 1 : MLRT_PACKET_RAYS, MLRT_PACKET_RAYS};
}

MLRT_INLINE struct ray_rows rows_of_lone_ray(const struct mlrt_lone_ray *ray)
{
    return (struct ray_rows){ray->origin, ray->direction, ray->reciprocal, 1, 1};
}

/* The same for the ray whose leaf is tested, of a call of its own or of a packet. */
MLRT_INLINE struct ray_rows rows_of_tested_ray(const struct mlrt_packet *packet, uint32_t lane,
                                               const struct mlrt_worker *worker)
{
    return worker->lone ? rows_of_lone_ray(worker->lone) : rows_of_lane(packet, NULL, lane);
}

MLRT_INLINE void set_single_ray(const struct ray_rows *rows, const struct mlrt_packet *packet, uint32_t lane,
                                struct single_ray *ray)
{
    float reach = 0;
    MLRT_UNROLL
    for (uint32_t k = 0; k < 3; ++k) {
        const float d = rows->direction[k * rows->step];
        const float r = rows->reciprocal[k * rows->step];
        const uint32_t lo = row_of_planes(0, k), hi = row_of_planes(1, k);
        ray->origin[k] = v_set1(rows->origin[k * rows->origin_step]);
        ray->direction[k] = v_set1(d);
        ray->near[k] = v_set1(r * (RECIPROCAL_SLACK - 1));
        ray->far[k] = v_set1(r * (-RECIPROCAL_SLACK - 1));
        ray->near_row[k] = d < 0 ? hi : lo;
        ray->far_row[k] = d < 0 ? lo : hi;
        reach = larger_of(fabsf(d), reach);
    }
    ray->reach = 4 * reach;
    ray->t_min = v_set1(packet->t_min[lane] + 0.0f); /* -0 becomes 0: see stack_entry */
    ray->lane = lane;
}

/*
 * Returns the boxes of a node that the ray can meet up to `limit`, one bit each. order[i] receives the distance at
 * which the ray enters box i, or with `any` the length that it spends in the box.
 */
MLRT_INLINE uint32_t meet_boxes(const struct single_ray *ray, const struct mlrt_bvh_node *node, float limit, int any,
                                float order[MLRT_BVH_WIDTH])
{
    enum { VECTORS = MLRT_BVH_WIDTH / VW };
    const char *planes = (const char *)node;
    vf first[VECTORS], last[VECTORS];
    uint32_t met = 0;
    MLRT_UNROLL
    for (int v = 0; v < VECTORS; ++v) first[v] = ray->t_min, last[v] = v_set1(limit);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const float *near = (const float *)(const void *)(planes + ray->near_row[k]);
        const float *far = (const float *)(const void *)(planes + ray->far_row[k]);
        MLRT_UNROLL
        for (int v = 0; v < VECTORS; ++v) {
            first[v] = v_max(v_mul(v_sub(ray->origin[k], v_load(near + v * VW)), ray->near[k]), first[v]);
            last[v] = v_min(v_mul(v_sub(ray->origin[k], v_load(far + v * VW)), ray->far[k]), last[v]);
        }
    }
    MLRT_UNROLL
    for (int v = 0; v < VECTORS; ++v) met |= m_bits(v_le(first[v], last[v])) << (v * VW);
    MLRT_UNROLL
    for (int v = 0; v < VECTORS; ++v) v_store(order + v * VW, any ? v_sub(last[v], first[v]) : first[v]);
    return met;
}

MLRT_INLINE uint32_t order_bits(float a)
{
    uint32_t bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}

MLRT_INLINE uint64_t stack_entry(float enter, uint32_t child)
{
    return (uint64_t)order_bits(enter) << 32 | child;
}

/*
 * The entry of a child; the lowest entry is visited first. For the closest hit that is the nearest child. For any hit
 * it is a leaf, which may end the search, or else the box that the ray spends the greatest length in. Nodes and leaves
 * visited per random ray (bindings/python/bench.py --only counts) if children are ordered by distance, with leaves
 * first, and with leaves first and then by length: erw6 2.54, 2.26, 2.25, conference 3.96, 3.63, 3.10, sponza 4.48,
 * 4.16, 3.40, clinic 3.59, 3.48, 3.15, dragon 4.49, 4.51, 4.14.
 */
MLRT_INLINE uint64_t child_entry(float order, uint32_t child, int any)
{
    if (!any) return stack_entry(order, child);
    return (uint64_t)(mlrt_bvh_quad_count(child) ? 0 : ~order_bits(order)) << 32 | child;
}

MLRT_INLINE void sort_entries(uint64_t *first, uint64_t *second)
{
    const uint64_t a = *first, b = *second;
    *first = a < b ? a : b;
    *second = a < b ? b : a;
}

/* The entry of the lowest child of `met`, which it leaves. */
MLRT_INLINE uint64_t take_child(const struct mlrt_bvh_node *node, uint32_t *met, const float order[MLRT_BVH_WIDTH],
                                int any)
{
    const uint32_t i = mlrt_lowest_bit(*met);
    *met &= *met - 1;
    return child_entry(order[i], node->child[i], any);
}

/*
 * Returns the child to visit first of those in `met`, which has at least one bit. The others go on the stack, sorted,
 * so that the next one to visit is on top. Up to three children are met mostly; then only their number takes branches.
 */
MLRT_INLINE uint32_t choose_child(const struct mlrt_bvh_node *node, uint32_t met, const float order[MLRT_BVH_WIDTH],
                                  int any, uint64_t *stack, uint32_t *count)
{
    if (!(met & (met - 1))) return node->child[mlrt_lowest_bit(met)];
    const uint32_t bottom = *count;
    uint64_t first = take_child(node, &met, order, any), second = take_child(node, &met, order, any);
    sort_entries(&first, &second);
    if (met) {
        uint64_t third = take_child(node, &met, order, any);
        sort_entries(&second, &third);
        sort_entries(&first, &second);
        stack[(*count)++] = third;
    }
    stack[(*count)++] = second;
    while (met) {
        uint64_t farther = take_child(node, &met, order, any);
        sort_entries(&first, &farther);
        uint32_t place = (*count)++;
        for (; place > bottom && stack[place - 1] < farther; --place) stack[place] = stack[place - 1];
        stack[place] = farther;
    }
    return (uint32_t)first;
}

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

/* The place of triangle `number`, which is among `numbers`. */
MLRT_INLINE uint32_t find_place(const uint32_t *numbers, uint32_t number)
{
    uint32_t place = 0;
    while (numbers[place] != number) ++place;
    return place;
}

/*
 * Compares triangles of a leaf that the ray of a lane surely hits with its nearest hit. Returns those that double does
 * not order. The nearer of the two becomes the nearest hit, without a branch. Its bounds do not depend on which it is
 * (settle_undecided), so traversal goes on before the order is known.
 */
MLRT_INLINE uint32_t order_places(const struct mlrt_job *job, const uint32_t *numbers, const float *corners,
                                  uint32_t row, uint32_t hit, uint32_t lane, struct corner_rows *nearest,
                                  struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct ray_rows rows = rows_of_tested_ray(packet, lane, worker);
    const struct two_vectors origin = load_twice(rows.origin, rows.origin_step),
                             direction = load_twice(rows.direction, rows.step);
    uint32_t left = 0;
    for (; hit; hit &= hit - 1) {
        const uint32_t i = mlrt_lowest_bit(hit), other = packet->nearest.triangle[lane];
        if (!nearest->corner) {
            const struct mlrt_corners found = mlrt_corners_of(&job->tree->by_number, other);
            *nearest = (struct corner_rows){found.corner, found.row};
        }
        const struct mlrt_corners first = {corners + i, row, 1}, second = {nearest->corner, (uint32_t)nearest->row, 1};
        const int wins_tie = numbers[i] < other;
        int is_first = comes_first(origin, direction, &first, &second, wins_tie), is_tie = 0;
        if (MLRT_UNLIKELY(is_first < 0)) {
            is_tie = !worker->lone && mlrt_known_plane_of(worker, numbers[i]) == mlrt_known_plane_of(worker, other);
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
        packet->nearest.triangle[lane] = (numbers[i] & take) | (other & ~take);
        nearest->corner = is_first ? first.corner : nearest->corner;
        nearest->row = is_first ? first.row : nearest->row;
    }
    return left;
}

/*
 * The places of a vector whose triangles a lane may meet between t_min and its nearest hit, by triangle_test.h, "BY
 * COMPONENTS".
 */
static MLRT_NOINLINE uint32_t places_ahead(const float *corners, uint32_t row, uint32_t lane,
                                           const struct mlrt_packet *packet, const struct mlrt_worker *worker)
{
    vf term[SIDE_TERMS], to[3], d[3];
    const struct ray_rows rows = rows_of_tested_ray(packet, lane, worker);
    struct float_test test;
    set_sides(corners, row, term);
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
 * Decides the triangles at places of a leaf that float leaves undecided. The ray is surely inside the edges of those in
 * `inside`. Of these, it surely meets those in `hit` behind t_min, at lo[i] or farther. Where any hit will do, `lo` is
 * NULL. `nearest`: where the corners of the nearest hit so far lie, if that is known. Returns where they lie
 * afterwards.
 *
 * Most rays that leave a surface begin one float beside it, and are undecided for the triangles of its plane. Float
 * tells by components that they leave them.
 *
 * If a triangle is surely hit, so that only its order with the nearest hit is in question, let t be the lesser of both
 * distances. It is at most that of the nearest hit so far, whose `hi` therefore stays, and not less than the lesser of
 * both lower bounds, which becomes `lo`.
 */
static MLRT_NOINLINE struct corner_rows settle_undecided(const struct mlrt_job *job, const uint32_t *numbers,
                                                         const float *corners, uint32_t row, uint32_t undecided,
                                                         uint32_t inside, uint32_t hit, const float *lo, uint32_t lane,
                                                         struct corner_rows nearest, struct mlrt_packet *packet,
                                                         struct mlrt_worker *worker)
{
    uint32_t tried = 0;
    hit &= undecided;
    if (undecided & ~hit) {
        undecided &= hit | places_ahead(corners, row, lane, packet, worker);
        if (!undecided) return nearest;
    }
    if (hit && packet->nearest.triangle[lane] != MLRT_NONE && !worker->scaled) {
        float least = packet->nearest.lo[lane];
        for (uint32_t left = hit; left; left &= left - 1) {
            const float x = lo[mlrt_lowest_bit(left)];
            least = x < least ? x : least;
        }
        packet->nearest.lo[lane] = least;
        tried = order_places(job, numbers, corners, row, hit, lane, &nearest, packet, worker);
        undecided = (undecided & ~hit) | tried;
        if (MLRT_LIKELY(!undecided)) return nearest;
    }
    const uint32_t before = packet->nearest.triangle[lane];
    decide_scaled_triangles(job, numbers, undecided, inside, tried, lane, packet, worker);
    const uint32_t after = packet->nearest.triangle[lane];
    return after == before ? nearest : (struct corner_rows){corners + find_place(numbers, after), row};
}

/*
 * Decides the triangles of a part of a leaf where the ray may be `inside` the edges. Sets *nearest if the nearest hit
 * changes. Returns 1 if a query for any hit has one.
 */
MLRT_INLINE int settle_places(const struct mlrt_job *job, int any, const struct leaf_part *part, vm inside,
                              const struct float_test *test, uint32_t lane, vf t_min, struct corner_rows *nearest,
                              struct mlrt_packet *packet, struct mlrt_worker *worker)
{
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
        *nearest = settle_undecided(job, part->numbers, part->corners, part->row, undecided, m_bits(verdict.inside),
                                    hit, any ? NULL : lo, lane, *nearest, packet, worker);
        return any && packet->nearest.triangle[lane] != MLRT_NONE;
    }
    return 0;
}

/*
 * Decides the triangles of a part of a leaf for a lane, given edge functions and D. Sets the rest of *test. `to` goes
 * from the origin to corners a. Sets *nearest if the nearest hit changes. Returns 1 if a query for any hit has one.
 */
MLRT_INLINE int settle_vector(const struct mlrt_job *job, int any, const struct leaf_part *part,
                              const vf term[SIDE_TERMS], const vf to[3], vf t_min, uint32_t lane,
                              struct corner_rows *nearest, struct float_test *test, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    set_edge_bound(term, to, test);
    const vm inside = may_be_inside(test, m_from_bits(ALL_LANES));
    if (VW <= 4 && !m_bits(inside)) return 0; /* wide vectors take one branch, after distances */
    set_plane(term, to, test);
    return settle_places(job, any, part, inside, test, lane, t_min, nearest, packet, worker);
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

/*
 * Tests the triangles of a leaf. Sets *nearest if the nearest hit changes. Returns 1 if a query for any hit has one.
 */
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
        set_side_sizes(ray->reach, term);
        if (settle_vector(job, any, &part, term, to, ray->t_min, ray->lane, nearest, &test, packet, worker)) return 1;
        part.places >>= VW;
        if (VW == MLRT_BVH_LEAF_LIMIT || !part.places) return 0;
        part.corners += VW;
        part.numbers += VW;
    }
}

/* Node `child`. Its byte offset is child * 56: cheaper than its number times the 448 bytes of a node. */
MLRT_INLINE const struct mlrt_bvh_node *node_of(const struct mlrt_bvh_node *nodes, uint32_t child)
{
    return (const struct mlrt_bvh_node *)((const char *)nodes + child * (sizeof *nodes / 8));
}

MLRT_INLINE float finite_limit(float hi)
{
    return hi < FLT_MAX ? hi : FLT_MAX;
}

/*
 * Traces one lane of a packet through `child` and the tree below it. `any` is that of the job. Returns where the
 * corners of its nearest hit lie; if nothing nearer was found, `corner` is NULL.
 */
MLRT_INLINE struct mlrt_corners trace_lane(const struct mlrt_job *job, int any, const struct ray_rows *rows,
                                           uint32_t lane, uint32_t child, struct mlrt_packet *packet,
                                           struct mlrt_worker *worker)
{
    const struct mlrt_bvh_node *nodes = job->tree->bvh.nodes;
    MLRT_ALIGNED(64) float order[MLRT_BVH_WIDTH];
    uint64_t stack[MLRT_BVH_STACK_LIMIT];
    struct corner_rows nearest = {NULL, 0};
    uint32_t count = 0;
    struct single_ray ray;
    set_single_ray(rows, packet, lane, &ray);
    float limit = finite_limit(packet->nearest.hi[lane]);
    COUNT(&worker->counters, packet_count, 1);
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        if (mlrt_bvh_quad_count(child) == 0) {
            const struct mlrt_bvh_node *node = node_of(nodes, child);
            const uint32_t met = meet_boxes(&ray, node, limit, any, order);
            if (met) {
                child = choose_child(node, met, order, any, stack, &count);
                continue;
            }
        } else {
            if (test_leaf(job, any, &ray, child, &nearest, packet, worker)) break;
            limit = finite_limit(packet->nearest.hi[lane]);
        }
        do {
            if (count == 0) return (struct mlrt_corners){nearest.corner, (uint32_t)nearest.row, 1};
            --count;
        } while (!any && stack[count] > stack_entry(limit, 0xFFFFFFFFu));
        child = (uint32_t)stack[count];
    }
    return (struct mlrt_corners){nearest.corner, (uint32_t)nearest.row, 1};
}

/* The same for lanes of packets, whose rays are many: compiled once for all queries. */
static MLRT_NOINLINE void trace_single(const struct mlrt_job *job, const struct ray_rows *rows, uint32_t lane,
                                       uint32_t child, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    (void)trace_lane(job, job->any, rows, lane, child, packet, worker);
}

#endif
