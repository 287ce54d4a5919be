/* SPDX-License-Identifier: MIT */
/*
 * t, u, v and facing of the hit of one ray (rule R5), with the widths of hit_numbers.h.
 *
 * A vector holds four doubles: first the coordinates of a point, later the determinants N, e_ca, e_ab, D. Each
 * determinant is a sum of three products, without fused multiply-add, and so has the roundings that are counted there.
 * `s` holds the sizes of p, c-a, a-b and d. The size of a determinant is the product of three of these: N is without d,
 * e_ca without a-b, e_ab without c-a, and D without p.
 */
#ifndef MLRT_HITS_REPORT_RAY_H
#define MLRT_HITS_REPORT_RAY_H

#include "exact/predicate.h"
#include "job/hit_terms.h"
#include "job/write_arrays.h"
#include "simd/simd.h"

MLRT_INLINE d4 cross_product_of_lanes(d4 a, d4 b)
{
    return d4_next(d4_sub(d4_mul(a, d4_next(b)), d4_mul(d4_next(a), b)));
}

/* Sets *report. Returns 0 and sets nothing if the judge has to compute it. */
MLRT_INLINE int report_one_ray(const struct mlrt_corners *of, const float origin[3], const float direction[3],
                               struct mlrt_hit_report *report)
{
    MLRT_ALIGNED(16) float values[4];
    const d4 a = d4_three(of->corner, of->row), d = d4_three(direction, 1);
    const d4 ab = d4_sub(a, d4_three(of->corner + 3 * of->row, of->row));
    const d4 ca = d4_sub(d4_three(of->corner + 6 * of->row, of->row), a);
    const d4 p = d4_sub(a, d4_three(origin, 1));
    const d4 normal = cross_product_of_lanes(ca, ab), moment = cross_product_of_lanes(p, d);
    const d4 x = d4_sums(d4_mul(p, normal), d4_mul(ca, moment), d4_mul(ab, moment), d4_mul(d, normal));
    const d4 s = d4_sums(d4_abs(p), d4_abs(ca), d4_abs(ab), d4_abs(d));
    const d4 size = d4_mul(s, d4_inside_out(d4_mul(s, d4_reversed(s))));

    /* The widths w of hit_numbers.h. */
    const d4 d_size = d4_lane(size, 3), inverse = d4_inverse(d4_lane(x, 3)), scale = d4_abs(inverse);
    const double n = MLRT_NUMERATOR_ERROR, d_error = MLRT_DENOMINATOR_ERROR;
    const d4 from_d =
        d4_mul(d4_first_of(d4_abs(x), d_size), d4_set(d_error * MLRT_GREATEST_D_SIZE, d_error, d_error, d_error));
    const d4 slack = d4_mul(d4_add(d4_mul(d4_set(n, n, n, n), size), from_d), scale), quotient = d4_mul(x, inverse);
    const unsigned certain = d4_round(values, d4_sub(quotient, slack), d4_add(quotient, slack));
    const double limit = MLRT_GREATEST_D_SIZE;
    if (!MLRT_GUESS &&
        MLRT_UNLIKELY((certain & 7) != 7 || !d4_lt(d4_mul(d_size, scale), d4_set(limit, limit, limit, limit))))
        return 0;
    *report = (struct mlrt_hit_report){values[0], values[1], values[2], d4_lt(x, d4_set(0, 0, 0, 0)) & 8 ? -1 : 1};
    return 1;
}

#endif
