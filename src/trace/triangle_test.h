/* SPDX-License-Identifier: MIT */
/*
 * The float test of rays that go one by one or lane by lane against triangles. A vector has one ray and many triangles,
 * or one triangle and many rays: the arithmetic is the same. What belongs to the triangle alone, its sides and their
 * products, is computed first, and may serve many rays.
 *
 * WHAT IS COMPUTED. Let p = fl(a - o), g = fl(a - c), h = fl(a - b), n = h x g, and r = d x p. Then, as in
 * determinants.h,
 *
 *     e_ca = g . r     -e_ab = h . r     D = d . n     N = p . n     e_bc = D - e_ca - e_ab
 *
 * Corner a is the first operand of all differences, since loads are the second.
 *
 * Let u = 2^-24. p, g and h have 1 rounding per component, r has 3 (p, product, difference), and n has 4. Product and
 * sums of a dot product add 3. So D, e_ca and e_ab have 7 roundings, and N has 8. Each is a determinant of three
 * vectors, and its error is relative to the sum of the magnitudes of its six products.
 * Let m be the largest |d_k|, and S, G, H the sums of the magnitudes of the components of p, g, h. For e_ca the sum of
 * the products is at most m S G: |p_i| |d_j| + |p_j| |d_i| <= m S, times |g_k|, summed over k. Likewise it is at most
 * m S H for e_ab, m G H for D, and S G H for N. e_bc has two roundings more, of at most the sum of the three. So
 * 9.001 u m (S G + S H + G H) bounds the errors of all edge functions; EDGE_BOUND has 11 u. With PLANE_BOUND, 16 u of
 * m G H, D has 8.9 u to spare, and with DISTANCE_BOUND, 12 u of S G H, N has 3.9 u. The comparison of distances, which
 * triangle_filter.h derives, needs 6.9 and 1.9. The bounds as computed are off by a few u of themselves, for which
 * there is room.
 *
 * ONE ORIGIN. If all rays start at o, then p is the same for all, and so are p x g and p x h:
 *
 *     e_ca = d . (p x g)     -e_ab = d . (p x h)
 *
 * These are the same determinants. p, g and h have 1 rounding, a cross product 3 more, and the product with d and its
 * sums 3: that makes 7 as well. So all bounds hold, with the greatest |d_k| of all rays for m.
 *
 * BY COMPONENTS. m G H and S G H are more than the sums of the magnitudes of the six products, s(D) and s(N): for a
 * triangle across an axis, all products of N but two are 0, and s(N) is its distance along that axis times |h_i g_j| +
 * |h_j g_i|. So if a ray begins one float beside the plane of a wall, N is below 12 u S G H but, unless the wall is a
 * needle, above 12 u s(N). Therefore a triangle that may be met where the ray begins is compared once more, with 16 u
 * s(D) and 12 u s(N). The errors are relative to these sums, so D has 7.9 u to spare after N -+ E and D -+ W, and N has
 * 2.9 u. The sums as computed have fewer roundings than the bounds above. They are multiplied by 4, too, and have the
 * same floor. What the quotients lose is not added, since only products are compared.
 *
 * Nothing here is scaled, but for the units (units.h). The corners of an odd triangle are NaN, and so are all numbers
 * computed from them. A comparison with a NaN is false, so the triangle is undecided.
 *
 * Underflow: a product loses 2^-150 at most; in n, r and the products with p that is 2^-149 for a component, and S, G,
 * H and 3 m are less than 2^63: so 2^-84 covers it, and DISTANCE_FLOOR = 2^-82 is added to each of the bounds. The
 * quotients that become t lose 2^-149, and D may be large here: for them, 2^-60 m G H is added to the bound of N.
 *
 * Overflow: cross products are at most 2^124, as magnitudes are 2^60 at most. If another number exceeds 2^126, its
 * bound overflows, because it is multiplied by 4 on the way. Then everything is undecided: no decision uses <= or >=,
 * which would hold between infinities. So scenes much smaller than 2^-20 or larger than 2^40 are slow here, not wrong.
 *
 * Based on: T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
 */
#ifndef MLRT_TRACE_TRIANGLE_TEST_H
#define MLRT_TRACE_TRIANGLE_TEST_H

#include "hits/triangle_filter.h"
#include "simd/simd.h"

/*
 * The share of the bound of D that is added to that of N: it makes PLANE_BOUND's 2^-20 m G H the 2^-60 m G H above.
 * The bound of D includes its floor, so the product is not denormal, which would take a hundred cycles. Unless t is
 * less than 2^-40, the error of D moves t by more than this does.
 */
#define QUOTIENT_FLOOR 0x1p-40f

/* What belongs to a triangle: vectors, of which three components follow each other, and factors of bounds. */
enum side_term {
    SIDE_CORNER,            /* a */
    SIDE_CA = 3,            /* g */
    SIDE_AB = 6,            /* h */
    SIDE_NORMAL = 9,        /* n */
    SIDE_EDGE_FACTOR = 12,  /* 4 m (G + H): times S it is a part of the bound of edge functions */
    SIDE_PLANE_FACTOR = 13, /* 4 m G H: the rest of it */
    SIDE_PLANE_SIZE = 14,   /* G H */
    SIDE_TERMS = 15
};

MLRT_INLINE vf sum_of_magnitudes(const vf a[3])
{
    return v_add(v_add(v_abs(a[0]), v_abs(a[1])), v_abs(a[2]));
}

/* Sets the vectors that belong to a vector of triangles. Each coordinate is a row; rows are `row` floats apart. */
MLRT_INLINE void set_sides(const float *corners, size_t row, vf term[SIDE_TERMS])
{
    const float *b = corners + 3 * row, *c = b + 3 * row;
    MLRT_UNROLL
    for (size_t k = 0; k < 3; ++k) {
        term[k] = v_load_any(corners + k * row);
        term[SIDE_CA + k] = v_sub(term[k], v_load_any(c + k * row));
        term[SIDE_AB + k] = v_sub(term[k], v_load_any(b + k * row));
    }
    cross_product(&term[SIDE_AB], &term[SIDE_CA], &term[SIDE_NORMAL]);
}

/* Sets the factors of bounds. `direction_limit` is 4 m. */
MLRT_INLINE void set_side_sizes(float direction_limit, vf term[SIDE_TERMS])
{
    const vf size_g = sum_of_magnitudes(&term[SIDE_CA]), size_h = sum_of_magnitudes(&term[SIDE_AB]);
    term[SIDE_PLANE_SIZE] = v_mul(size_g, size_h);
    term[SIDE_EDGE_FACTOR] = v_mul(v_add(size_g, size_h), v_set1(direction_limit));
    term[SIDE_PLANE_FACTOR] = v_mul(term[SIDE_PLANE_SIZE], v_set1(direction_limit));
}

/* How far a ray passes inside of the edges, given e_ca, -e_ab and D. */
MLRT_INLINE vf inside_of_sides(vf ca, vf opposite_ab, vf determinant)
{
    return inside_of_edges(v_opposite(opposite_ab), ca, v_add(v_sub(determinant, ca), opposite_ab));
}

/*
 * Sets edge functions and D. `to` goes from the origin to corner a, as it does below. A single ray computes bounds only
 * afterwards: they are needed last, and with vectors of 512 bits in two halves they would delay what it waits for.
 */
MLRT_INLINE void set_edges(const vf term[SIDE_TERMS], const vf to[3], const vf d[3], struct float_test *test)
{
    vf moment[3];
    cross_product(d, to, moment);
    const vf ca = dot_product(&term[SIDE_CA], moment), opposite_ab = dot_product(&term[SIDE_AB], moment);
    test->determinant = dot_product(d, &term[SIDE_NORMAL]);
    test->inner = inside_of_sides(ca, opposite_ab, test->determinant);
}

/* Sets the bound of edge functions. */
MLRT_INLINE void set_edge_bound(const vf term[SIDE_TERMS], const vf to[3], struct float_test *test)
{
    const vf size = v_mul_add(sum_of_magnitudes(to), term[SIDE_EDGE_FACTOR], term[SIDE_PLANE_FACTOR]);
    test->edge_bound = MLRT_GUESS ? v_set1(0) : v_mul_add(size, v_set1(EDGE_BOUND / 4), v_set1(DISTANCE_FLOOR));
}

/* Sets N, and the bounds of N and D. */
MLRT_INLINE void set_plane(const vf term[SIDE_TERMS], const vf to[3], struct float_test *test)
{
    test->distance = dot_product(to, &term[SIDE_NORMAL]);
    test->plane_bound = test->distance_bound = v_set1(0);
    if (MLRT_GUESS) return;
    const vf floor = v_set1(DISTANCE_FLOOR), size = v_mul(sum_of_magnitudes(to), v_set1(4));
    test->plane_bound = v_mul_add(term[SIDE_PLANE_FACTOR], v_set1(PLANE_BOUND / 4), floor);
    test->distance_bound = v_mul_add(v_mul(size, term[SIDE_PLANE_SIZE]), v_set1(DISTANCE_BOUND / 4),
                                     v_mul_add(test->plane_bound, v_set1(QUOTIENT_FLOOR), floor));
}

/* Sets D, N and their bounds by components: see above. No factor of `term` is read. */
MLRT_INLINE void set_plane_by_components(const vf term[SIDE_TERMS], const vf to[3], const vf d[3],
                                         struct float_test *test)
{
    const vf *g = &term[SIDE_CA], *h = &term[SIDE_AB];
    const vf four = v_set1(4), floor = v_set1(DISTANCE_FLOOR);
    vf size_of_d = v_set1(0), size_of_n = v_set1(0);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const vf size = v_mul_add(v_abs(h[i]), v_abs(g[j]), v_mul(v_abs(h[j]), v_abs(g[i])));
        size_of_d = v_mul_add(v_abs(d[k]), size, size_of_d);
        size_of_n = v_mul_add(v_abs(to[k]), size, size_of_n);
    }
    test->determinant = dot_product(d, &term[SIDE_NORMAL]);
    test->distance = dot_product(to, &term[SIDE_NORMAL]);
    test->plane_bound = v_mul_add(v_mul(size_of_d, four), v_set1(PLANE_BOUND / 4), floor);
    test->distance_bound = v_mul_add(v_mul(size_of_n, four), v_set1(DISTANCE_BOUND / 4), floor);
}

#endif
