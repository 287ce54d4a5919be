/* SPDX-License-Identifier: MIT */
/*
 * Close calls: lanes that the float filters leave undecided for a triangle are decided in double, many at once. Only
 * lanes that double leaves undecided too go to the judge, one by one (undecided.h). The answers are those of the
 * judge; the bounds of t that are kept with a hit are a little wider than the judge's.
 *
 * WHAT IS COMPUTED. The determinants at the head of determinants.h, with p = a - o and n = b-a cross c-a:
 *
 *     D = d . n     N = p . n     e_ab = (d cross p) . b-a     e_ca = -(d cross p) . c-a     e_bc = D - e_ab - e_ca
 *
 * The size s(x) of a determinant is the sum of the magnitudes of its six products. It is computed in the same way as
 * the determinant, with all factors and sums positive. (It is not the product of the sizes of its vectors.) As in
 * determinants.h, with u = 2^-53, a determinant as computed is off by at most gamma_8 times the true size (e_bc:
 * gamma_9 times the sum of three). A size as computed has at most 8 factors (e_bc: 10), so it is at least (1 - u)^10 of
 * the true one. That makes 8.001 u and 9.001 u of the computed size. If a size is 0, all six products are 0, and so is
 * the determinant: nothing here underflows (determinants.h, "RANGE").
 *
 * BOUNDS. In signs that make D positive, let E = 12 u s(N) and W = 12 u s(D). N -+ E and D -+ W have one more rounding
 * each, of at most 1.001 u of the size, and that of the bound, of less than 0.001 u: so they are bounds of the true
 * numerator and denominator with 2.9 u of the size to spare. The size is at least (1 - 9 u) of the magnitude. So there
 * is room for one rounding, by u of itself, of a product of one of these bounds with a float or with another bound:
 *
 *     t > x     if N - E > x (D + W)                          t < x     if N + E < x (D - W)         for x >= 0
 *     t > t'    if (N - E) (D' - W') > (N' + E') (D + W)      t < t'    likewise, with the triangles exchanged
 *
 * if D > W and D' > W'. The same holds with >= in place of >, since either both sides are 0 in exact arithmetic or the
 * room that is left makes the inequality strict. x may be infinite. Likewise the quotients (N - E) / (D + W) and
 * (N + E) / (D - W) are below and above t after their rounding. A product of two bounds may be as small as 2^-1100, and
 * underflow to 0. But then one factor is a difference that is nearly 0, so the product is the lesser side of its
 * comparison. The other side has a sum, and is at least 2^-894, or exactly 0, which means t = 0: that is no hit.
 *
 * If D > W, take the edge functions with the sign that makes D positive, and their bounds 12 u s(e). A ray is surely
 * inside if each is at least its bound. It is surely outside if one is less than its negative bound: D is the sum of
 * the three, so another one is positive.
 */
#ifndef MLRT_HITS_CLOSE_CALLS_H
#define MLRT_HITS_CLOSE_CALLS_H

#include <float.h>

#include "exact/rounding.h"
#include "hits/outcome.h"
#include "hits/undecided.h"
#include "job/read_lanes.h"
#include "job/stop.h"
#include "simd/doubles.h"
#include "simd/simd.h"

#define CLOSE_ERROR    (12 * MLRT_UNIT_ROUNDOFF)
#define DOUBLE_LANES   ((1u << DW) - 1)
#define DOUBLE_VECTORS (MLRT_PACKET_RAYS / DW)

/* The vectors and determinants of a triangle, DW lanes of each. */
struct close_triangle {
    vd a[3];
    vd ab[3];
    vd ac[3];
    vd normal[3];
    vd normal_size[3];
    vd to_a[3]; /* p, N and its size: of all lanes if they have an apex, else of the vector that was tested last */
    vd n;
    vd n_size;
};

/* N and D between bounds, with the sign of D. */
struct close_bounds {
    vd d;
    vd d_size;
    vd least_n;
    vd greatest_n;
    vd least_d;
    vd greatest_d;
};

/* A cross product of magnitudes, where the difference of two products becomes their sum. */
MLRT_INLINE void cross_product_of_sizes(const vd a[3], const vd b[3], vd cross[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = d_add(d_abs(d_mul(a[i], b[j])), d_abs(d_mul(a[j], b[i])));
    }
}

/* Sets p, N and the size of N for the DW lanes from `lane` on. */
MLRT_INLINE void place_origin(const struct mlrt_packet *packet, uint32_t lane, struct close_triangle *triangle)
{
    for (int k = 0; k < 3; ++k) triangle->to_a[k] = d_sub(triangle->a[k], origins_in_double(packet, k, lane));
    triangle->n = dot_product_of_doubles(triangle->to_a, triangle->normal);
    triangle->n_size = dot_product_of_sizes(triangle->to_a, triangle->normal_size);
}

static MLRT_NOINLINE void set_close_triangle(const struct mlrt_triangle *corners, const struct mlrt_packet *packet,
                                             struct close_triangle *triangle)
{
    for (int k = 0; k < 3; ++k) {
        triangle->a[k] = d_set1(corners->v[0][k]);
        triangle->ab[k] = d_sub(d_set1(corners->v[1][k]), triangle->a[k]);
        triangle->ac[k] = d_sub(d_set1(corners->v[2][k]), triangle->a[k]);
    }
    cross_product_of_doubles(triangle->ab, triangle->ac, triangle->normal);
    cross_product_of_sizes(triangle->ab, triangle->ac, triangle->normal_size);
    if (packet->has.apex) place_origin(packet, 0, triangle);
}

/* Bounds N and D for the DW lanes from `lane` on. */
static MLRT_NOINLINE void bound_quotient(struct close_triangle *triangle, const struct mlrt_packet *packet,
                                         uint32_t lane, struct close_bounds *bounds)
{
    if (!packet->has.apex) place_origin(packet, lane, triangle);
    const vd error = d_set1(CLOSE_ERROR);
    vd direction[3];
    load_directions(packet, lane, direction);
    bounds->d = dot_product_of_doubles(direction, triangle->normal);
    bounds->d_size = dot_product_of_sizes(direction, triangle->normal_size);
    const vd n = d_flip(triangle->n, bounds->d), n_error = d_mul(error, triangle->n_size);
    const vd size = d_abs(bounds->d), d_error = d_mul(error, bounds->d_size);
    bounds->least_n = d_sub(n, n_error);
    bounds->greatest_n = d_add(n, n_error);
    bounds->least_d = d_sub(size, d_error);
    bounds->greatest_d = d_add(size, d_error);
}

/* Computes the negated edge functions of DW lanes in D's sign, so that all are negative inside, and their bounds. */
MLRT_INLINE void bound_edges(const struct close_triangle *triangle, const struct close_bounds *bounds,
                             const struct mlrt_packet *packet, uint32_t lane, vd edge[3], vd bound[3])
{
    const vd error = d_set1(CLOSE_ERROR), zero = d_set1(0);
    vd direction[3], moment[3], moment_size[3];
    load_directions(packet, lane, direction);
    cross_product_of_doubles(triangle->to_a, direction, moment);
    cross_product_of_sizes(triangle->to_a, direction, moment_size);
    const vd ab = dot_product_of_doubles(triangle->ab, moment);
    const vd ca = d_sub(zero, dot_product_of_doubles(triangle->ac, moment));
    const vd bc = d_sub(zero, d_add(d_add(bounds->d, ab), ca));
    const vd ab_size = dot_product_of_sizes(triangle->ab, moment_size);
    const vd ca_size = dot_product_of_sizes(triangle->ac, moment_size);
    const vd bc_size = d_add(d_add(bounds->d_size, ab_size), ca_size);
    edge[0] = d_flip(ab, bounds->d), edge[1] = d_flip(bc, bounds->d), edge[2] = d_flip(ca, bounds->d);
    bound[0] = d_mul(error, ab_size), bound[1] = d_mul(error, bc_size), bound[2] = d_mul(error, ca_size);
}

/* Sets the lanes, of DW, that are surely inside the edges, and surely outside; valid where the sign of D is sure. */
MLRT_INLINE void find_sides(const struct close_triangle *triangle, const struct close_bounds *bounds,
                            const struct mlrt_packet *packet, uint32_t lane, uint32_t *inside, uint32_t *outside)
{
    const vd zero = d_set1(0);
    vd edge[3], bound[3];
    bound_edges(triangle, bounds, packet, lane, edge, bound);
    const vd least = d_max(d_max(d_sub(edge[0], bound[0]), d_sub(edge[1], bound[1])), d_sub(edge[2], bound[2]));
    const vd greatest = d_max(d_max(d_add(edge[0], bound[0]), d_add(edge[1], bound[1])), d_add(edge[2], bound[2]));
    *outside = d_gt(least, zero);
    *inside = ~d_gt(greatest, zero) & DOUBLE_LANES;
}

/* The decisions for a triangle and a set of lanes. Lanes in no set are undecided. */
struct close_verdict {
    uint32_t passed; /* surely not hit, or surely behind the nearest hit so far */
    uint32_t hit;    /* surely inside the edges, and behind t_min */
    uint32_t nearer; /* of `hit`, those that surely are before the nearest hit so far */
};

/*
 * Tests DW lanes from `lane` on; bit 0 of all sets is that lane. `inside`: those already known to be inside the edges.
 * The nearest hits so far, or the ends of the rays, lie between t = `lo` and `hi`.
 */
MLRT_INLINE struct close_verdict test_lanes(const struct close_triangle *triangle, const struct mlrt_packet *packet,
                                            uint32_t lane, uint32_t lanes, uint32_t inside, vd lo, vd hi,
                                            const struct close_bounds *bounds)
{
    struct close_verdict verdict;
    const vd t_min = d_load(packet->t_min + lane), zero = d_set1(0);
    const uint32_t certain = d_gt(bounds->least_d, zero), parallel = ~d_gt(bounds->greatest_d, zero);
    const uint32_t beyond = d_gt(bounds->least_n, d_mul(hi, bounds->greatest_d));
    const uint32_t before = ~d_gt(bounds->greatest_n, d_mul(t_min, bounds->least_d));
    const uint32_t begun = d_gt(bounds->least_n, d_mul(t_min, bounds->greatest_d));
    verdict.passed = (certain & (beyond | before)) | parallel;
    verdict.nearer = d_gt(d_mul(lo, bounds->least_d), bounds->greatest_n);
    if (lanes & ~inside & ~verdict.passed) {
        uint32_t surely, outside;
        find_sides(triangle, bounds, packet, lane, &surely, &outside);
        verdict.passed |= certain & outside;
        inside |= surely;
    }
    verdict.passed &= lanes;
    verdict.hit = lanes & certain & inside & begun & ~verdict.passed;
    verdict.nearer &= verdict.hit;
    return verdict;
}

/*
 * Compares the distances of a triangle, bounded by `of_triangle`, with those of triangle `nearest`, the nearest hit so
 * far of all `lanes`. Returns the lanes where the first is surely nearer, and adds to *farther those where it surely is
 * farther.
 */
static MLRT_NOINLINE uint32_t compare_with_nearest(const struct mlrt_tree *tree, uint32_t nearest,
                                                   const struct mlrt_packet *packet, uint32_t lanes,
                                                   const struct close_bounds *of_triangle, uint32_t *farther)
{
    struct close_triangle triangle;
    uint32_t nearer = 0;
    const struct mlrt_triangle given = mlrt_triangle_at(&tree->by_number, nearest);
    set_close_triangle(&given, packet, &triangle);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        struct close_bounds other;
        const uint32_t among = lanes >> lane & DOUBLE_LANES;
        if (!among) continue;
        bound_quotient(&triangle, packet, lane, &other);
        const struct close_bounds *bounds = &of_triangle[lane / DW];
        const vd zero = d_set1(0);
        const uint32_t certain = among & d_gt(bounds->least_d, zero) & d_gt(other.least_d, zero);
        nearer |= (certain & d_gt(d_mul(other.least_n, bounds->least_d), d_mul(bounds->greatest_n, other.greatest_d)))
                  << lane;
        *farther |= (certain & d_gt(d_mul(bounds->least_n, other.least_d), d_mul(other.greatest_n, bounds->greatest_d)))
                    << lane;
    }
    return nearer;
}

/* Likewise for lanes whose nearest hits are different triangles. */
MLRT_INLINE uint32_t compare_with_all_nearest(const struct mlrt_tree *tree, const struct mlrt_packet *packet,
                                              uint32_t lanes, const struct close_bounds *of_triangle, uint32_t *farther)
{
    uint32_t nearer = 0;
    while (lanes) {
        const uint32_t nearest = packet->nearest.triangle[mlrt_lowest_bit(lanes)];
        const uint32_t same = lanes & lanes_of_triangle(packet, nearest);
        lanes &= ~same;
        if (nearest != MLRT_NONE) nearer |= compare_with_nearest(tree, nearest, packet, same, of_triangle, farther);
    }
    return nearer;
}

/*
 * Makes the triangle the nearest hit of the lanes `nearer`. Rounding the bounds of t to floats can move them inward by
 * half a unit in the last place, so they are moved outward by more than that; 2^-149 is for bounds that become
 * denormal.
 */
MLRT_INLINE void keep_close_hits(uint32_t number, uint32_t nearer, const struct close_bounds *of_triangle,
                                 struct mlrt_packet *packet)
{
    MLRT_ALIGNED(64) float lo[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float hi[MLRT_PACKET_RAYS];
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        const struct close_bounds *bounds = &of_triangle[lane / DW];
        if (!(nearer >> lane & DOUBLE_LANES)) continue;
        const vd least = d_mul(d_div(bounds->least_n, bounds->greatest_d), d_set1(1 - 0x1p-23));
        const vd greatest = d_mul(d_div(bounds->greatest_n, bounds->least_d), d_set1(1 + 0x1p-23));
        d_store(lo + lane, d_max(d_sub(least, d_set1(0x1p-149)), d_set1(0)));
        d_store(hi + lane, d_add(greatest, d_set1(0x1p-149)));
    }
    for (; nearer; nearer &= nearer - 1) {
        const uint32_t lane = mlrt_lowest_bit(nearer);
        packet->nearest.triangle[lane] = number;
        packet->nearest.lo[lane] = lo[lane] < FLT_MAX ? lo[lane] : FLT_MAX; /* t may exceed all floats */
        packet->nearest.hi[lane] = hi[lane];
    }
}

/*
 * Decides `lanes` that have no hit yet, and surely hit the triangle unless they end before it. Rays from a light often
 * end in the plane of a wall; if that plane is across an axis, mlrt_reaches_flat decides whether they reach the
 * triangle. Returns the lanes that reach it, and adds to *passed those that end before it. Other lanes remain
 * undecided.
 */
static MLRT_NOINLINE uint32_t find_lanes_at_end(const struct mlrt_triangle *triangle, const struct mlrt_packet *packet,
                                                uint32_t lanes, uint32_t *passed)
{
    uint32_t reached = 0;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        int sign;
        mlrt_get_segment(packet, lane, &ray);
        if (!mlrt_reaches_flat(&ray, triangle, ray.t_max, &sign)) break;
        reached |= (uint32_t)(sign <= 0) << lane;
        *passed |= (uint32_t)(sign > 0) << lane;
    }
    return reached;
}

/*
 * Decides `lanes` in double. Returns the lanes where the triangle is the nearest hit now; *left receives the undecided
 * lanes.
 */
static MLRT_NOINLINE uint32_t decide_by_doubles(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes,
                                                uint32_t inside, struct mlrt_packet *packet, uint32_t *left)
{
    struct close_triangle triangle;
    struct close_bounds bounds[DOUBLE_VECTORS];
    uint32_t passed = 0, hit = 0, nearer = 0, farther = 0;
    const struct mlrt_triangle given = mlrt_triangle_at(&tree->by_number, number);
    set_close_triangle(&given, packet, &triangle);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        const uint32_t among = lanes >> lane & DOUBLE_LANES;
        if (!among) continue;
        bound_quotient(&triangle, packet, lane, &bounds[lane / DW]);
        const struct close_verdict verdict =
            test_lanes(&triangle, packet, lane, among, inside >> lane, d_load(packet->nearest.lo + lane),
                       d_load(packet->nearest.hi + lane), &bounds[lane / DW]);
        passed |= verdict.passed << lane;
        hit |= verdict.hit << lane;
        nearer |= verdict.nearer << lane;
    }
    *left = lanes & ~(passed | nearer);
    if (*left) {
        nearer |= hit & compare_with_all_nearest(tree, packet, *left, bounds, &farther);
        *left &= ~(farther | nearer);
    }
    const uint32_t at_end = *left & hit & lanes_of_triangle(packet, MLRT_NONE);
    if (at_end) {
        nearer |= find_lanes_at_end(&given, packet, at_end, &farther);
        *left &= ~(farther | nearer);
    }
    if (nearer) keep_close_hits(number, nearer, bounds, packet);
    return nearer;
}

/*
 * As mlrt_decide_lanes (undecided.h), which it calls for the lanes that it leaves undecided. Lanes whose nearest hit is
 * known to lie in the triangle's plane are settled first; then the triangle is tested in double, and its distances are
 * compared with those of the nearest hits.
 */
static MLRT_NOINLINE uint32_t decide_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes,
                                           uint32_t inside, struct mlrt_packet *packet, struct mlrt_worker *worker,
                                           mlrt_counters *counters)
{
    if (mlrt_is_stopped_in_step(worker)) return 0;
    const uint32_t tied = mlrt_settle_ties(NULL, number, lanes, inside, packet, worker), among = lanes & ~tied;
    uint32_t left = 0, nearer = 0;
    if (among) nearer = decide_by_doubles(tree, number, among, inside, packet, &left);
    const uint64_t test_count = counters ? counters->undecided_test_count : 0;
    if (MLRT_UNLIKELY(left)) nearer |= mlrt_decide_lanes(tree, number, left, inside, packet, worker, counters);
    if (counters) {
        counters->tie_lane_count += mlrt_count_bits(tied);
        counters->judged_lane_count += mlrt_count_bits(among & ~left);
        if (among & ~left) counters->undecided_test_count = test_count + 1; /* both parts count as one test */
    }
    return nearer;
}

#endif
