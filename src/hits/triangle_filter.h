/* SPDX-License-Identifier: MIT */
/*
 * The float filter of rays against triangles. With bounds on its errors, float arithmetic decides nearly all tests:
 * surely a miss or farther, or surely a nearer hit. What is undecided goes to close_calls.h, and at last to the judge.
 * The bounds below are those of a packet against a triangle; those of single rays and lanes are in
 * trace/triangle_test.h, those of bundles in trace/leaf.h.
 *
 * WHAT IS COMPUTED. Relative to the origin o let a = fl(v_i - o), b = fl(v_j - o), and g = fl(v_j - v_i) from the
 * corners themselves. Then
 *
 *     e' = d . ((a + b) x g / size)        has the sign of the edge function e_ij
 *     D' = d . (n / size)                  n = (a - c) x (b - a)
 *     N' = fl(a - o) . (n / size)          so t = N' / D'
 *
 * where each cross product has its own size. Let M_k be the sum of the magnitudes of the two products in its component
 * k, with |a| + |b| in place of |a + b|. The size is M_main + (M_j + M_l) / 2, where the main axis is that along which
 * the rays go. |a_k| + |b_k| is the larger of |a_k + b_k| and |a_k - b_k|, which are computed already, but for 3 u of
 * itself; for n, a larger value does no harm. (a + b) x g = 2 (a x b); but a x b cancels for a small triangle far
 * away, and (a + b) x g does not: its error shrinks with the edge. Only the signs of e' and the ratios of N' and D'
 * matter, so they can be scaled, and with this scale one bound holds for all triangles.
 *
 * EDGES. Let u = 2^-24, and R at least |d_main|, 2 |d_j| and 2 |d_l| of all rays of the packet. Roundings of a
 * component of a + b: 1 for each of a and b, 1 for their sum, together 2 u of |a_k| + |b_k| (not of |a_k + b_k|, which
 * can be much smaller). The edge has 1, the products of the cross product 1, their subtraction 1, 1 / size 1, the
 * product with it 1; in the dot product the products have 1 and the sums 2. That makes 10, relative to the sum of
 * |d_k| M_k / size, which is at most R for the size without rounding. The size as computed is smaller by at most 8
 * roundings. So |e' - exact| <= 10.001 u R.
 *
 * With fused multiply-add, cross and dot products have one rounding where a product and a sum have one each: fewer than
 * are counted here.
 *
 * Underflow: float sums have none. A product in the cross product may lose 2^-150; since size is made at least 2^-100,
 * the three components lose at most 2^-47 R in all. The product with 1 / size may lose 2^-150 and so may those with d:
 * negligible beside u R, since R >= 2^-60 (packet.h). So EDGE_BOUND R = 11 u R is a bound. Overflow: magnitudes up to
 * 2^60 make sizes of at most 2^125, whose reciprocals are not denormal. So all numbers are finite, and there is no NaN,
 * which v_min would drop. Without the least size there could be one, since a cross product can underflow to 0.
 *
 * DISTANCES. D' has 9 roundings, so it is off by 9.001 u R, and |D'| < 1.001 R. N' has 10. With A for the components
 * of a as R is for those of d, N' is off by 10.001 u A, and by 2^-148 where its products underflow, and
 * |N'| < 1.001 A. In signs that make D' positive, let E = 12 u A + 2^-82 and W = 16 u R. Then N' - E and N' + E, as
 * rounded, are bounds of the true numerator with 2^-83 to spare, and D' - W and D' + W are bounds of the true
 * denominator with 5.9 u R to spare.
 *
 * So t < x if N' + E < x (D' - W), and t > x if N' - E > x (D' + W), for x >= 0: the rounding of the product takes
 * 1.1 u R of the room that W leaves, and the 2^-150 that it may lose are negligible beside 2^-83. x may be infinite,
 * and so may the product: D' - W is positive wherever the comparison is used, and no N' is infinite.
 *
 * Let D' > 2 W and s = W / D'. Then t lies between (N' - E) / D' (1 - s) and (N' + E) / D' (1 + 2 s): D' is off by
 * 9.001 / 16 s of itself, and the room that s leaves, at least 6.9 u, is more than the four roundings of each take.
 * They may lose 2^-149, less than 2^-83 / D'. The lower bound is kept for hits only, and is finite: along some axis
 * |d_k| >= 2^-60, and a hit is at most 2^61 away, so t <= 2^121. (The upper bound may be infinite.)
 */
#ifndef MLRT_HITS_TRIANGLE_FILTER_H
#define MLRT_HITS_TRIANGLE_FILTER_H

#include "simd/simd.h"

#if MLRT_GUESS
#define EDGE_BOUND     0.0f
#define PLANE_BOUND    0.0f
#define DISTANCE_BOUND 0.0f
#define DISTANCE_FLOOR 0.0f
#else
#define EDGE_BOUND     (11 * 0x1p-24f)
#define PLANE_BOUND    (16 * 0x1p-24f)
#define DISTANCE_BOUND (12 * 0x1p-24f)
#define DISTANCE_FLOOR 0x1p-82f
#endif
#define SMALLEST_SIZE 0x1p-100f

MLRT_INLINE void cross_product(const vf first[3], const vf second[3], vf cross[3])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = v_mul_sub(first[i], second[j], v_mul(first[j], second[i]));
    }
}

MLRT_INLINE vf dot_product(const vf a[3], const vf b[3])
{
    return v_mul_add(a[2], b[2], v_mul_add(a[1], b[1], v_mul(a[0], b[0])));
}

/* The cross product of a + b, or of a side, and an edge, divided by its size: see the head of this file. */
MLRT_INLINE void scaled_cross_product(const vf sum[3], const vf edge[3], uint32_t main_axis, vf cross[3])
{
    cross_product(sum, edge, cross);
    if (MLRT_GUESS) return;
    const uint32_t a = main_axis, j = (a + 1) % 3, l = (a + 2) % 3;
    vf magnitude[3], length[3];
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        length[k] = v_abs(edge[k]);
        magnitude[k] = v_max(v_abs(sum[k]), length[k]);
    }
    const vf main = v_add(v_mul(magnitude[j], length[l]), v_mul(magnitude[l], length[j]));
    const vf others =
        v_add(v_mul(magnitude[a], v_add(length[j], length[l])), v_mul(length[a], v_add(magnitude[j], magnitude[l])));
    const vf size = v_add(main, v_mul(others, v_set1(0.5f)));
    const vf scale = v_div(v_set1(1), v_max(size, v_set1(SMALLEST_SIZE)));
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) cross[k] = v_mul(cross[k], scale);
}

/* The filter's verdict on a vector of tests. Those in neither of the first two surely miss, or hit no nearer. */
struct verdict {
    vm nearer; /* surely hit, surely before the nearest hit so far */
    vm undecided;
    vm inside; /* surely inside all edges */
    vf lo;     /* where nearer: lo <= t <= hi */
    vf hi;
};

/* The numbers that the filter compares, and bounds of their errors. */
struct float_test {
    vf inner; /* how far inside of the edges: the least of the edge functions, or of their opposites */
    vf edge_bound;
    vf determinant; /* D */
    vf plane_bound; /* of D */
    vf distance;    /* N, which is t D */
    vf distance_bound;
};

/* How far a ray passes inside of three edges: below 0 if the functions of two differ in sign. */
MLRT_INLINE vf inside_of_edges(vf ab, vf ca, vf bc)
{
    return v_max(v_min(v_min(ab, ca), bc), v_opposite(v_max(v_max(ab, ca), bc))); /* bc is the last to be known */
}

/* The lanes of `active` that are not surely outside the edges. */
MLRT_INLINE vm may_be_inside(const struct float_test *test, vm active)
{
    return m_andnot(active, v_lt(test->inner, v_opposite(test->edge_bound)));
}

/* Bounds of N and D, whose fraction is t, in signs that make D positive. */
struct fraction {
    vf least_n;
    vf greatest_n;
    vf least_d;
    vf greatest_d;
};

MLRT_INLINE struct fraction bound_fraction(const struct float_test *test)
{
    const vf size = v_abs(test->determinant), distance = v_flip(test->distance, test->determinant);
    return (struct fraction){v_sub(distance, test->distance_bound), v_add(distance, test->distance_bound),
                             v_sub(size, test->plane_bound), v_add(size, test->plane_bound)};
}

/* Those of `candidates` that are not surely before t_min, nor surely behind the nearest hits, which lie before `hi`. */
MLRT_INLINE vm may_be_nearer(const struct float_test *test, vm candidates, vf t_min, vf hi)
{
    const struct fraction t = bound_fraction(test);
    const vm farther = m_or(v_gt(t.least_n, v_mul(hi, t.greatest_d)), v_lt(t.greatest_n, v_mul(t_min, t.least_d)));
    return m_andnot(candidates, m_and(v_gt(t.least_d, test->plane_bound), farther));
}

/* The triangles whose planes are surely met behind t_min, where D has a certain sign. */
MLRT_INLINE vm surely_begun(const struct float_test *test, vf t_min)
{
    const struct fraction t = bound_fraction(test);
    return v_gt(t.least_n, v_mul(t_min, t.greatest_d));
}

/*
 * The verdict on `candidates`, but for its lo and hi. These are not surely outside, and may be nearer as above. The
 * nearest hits so far lie behind `lo`.
 */
MLRT_INLINE struct verdict compare_with_nearest_hits(const struct float_test *test, vm candidates, vf t_min, vf lo)
{
    struct verdict verdict;
    const struct fraction t = bound_fraction(test);
    const vm certain = m_and(candidates, v_gt(t.least_d, test->plane_bound));
    const vm before = v_lt(t.greatest_n, v_mul(lo, t.least_d));
    verdict.inside = m_and(certain, v_gt(test->inner, test->edge_bound));
    verdict.nearer = m_and(verdict.inside, m_and(before, surely_begun(test, t_min)));
    verdict.undecided = m_andnot(candidates, verdict.nearer);
    verdict.lo = verdict.hi = v_set1(0);
    return verdict;
}

/* Sets lo and hi of t = N / |D| as derived at the head of this file, with E the bound of N, and W that of D. */
MLRT_INLINE void bound_distances(const struct float_test *test, struct verdict *verdict)
{
    const struct fraction t = bound_fraction(test);
    const vf inverse = v_div(v_set1(1), v_abs(test->determinant)), slack = v_mul(inverse, test->plane_bound);
    verdict->lo = v_mul(v_mul(t.least_n, inverse), v_sub(v_set1(1), slack));
    verdict->hi = v_mul(v_mul(t.greatest_n, inverse), v_add(v_set1(1), v_add(slack, slack)));
}

/* The verdict on candidates that are not surely outside. */
MLRT_INLINE struct verdict compare_distances(const struct float_test *test, vm candidates, vf t_min, vf lo, vf hi)
{
    const vm left = may_be_nearer(test, candidates, t_min, hi);
    struct verdict verdict = compare_with_nearest_hits(test, left, t_min, lo);
    if (m_bits(verdict.nearer)) bound_distances(test, &verdict);
    return verdict;
}

#endif
