/* SPDX-License-Identifier: MIT */
/*
 * Which of two triangles a ray hits first, in double: the determinants of determinants.h, with their bounds, of both
 * triangles at once. Text of the kernels, which have instructions for it that others lack.
 */
#ifndef MLRT_EXACT_ORDER_H
#define MLRT_EXACT_ORDER_H

#include <math.h>
#include <stddef.h>

#include "exact/determinants.h"
#include "exact/quotients.h"
#include "simd/double_pair.h"

/* A vector of each of two triangles. */
struct two_vectors {
    d2 x, y, z;
};

/* Corner 0, 1 or 2 of both. */
MLRT_INLINE struct two_vectors load_two(const struct mlrt_corners *first, const struct mlrt_corners *second,
                                        size_t corner)
{
    const size_t row = first->row, other = second->row;
    const float *p = first->corner + 3 * corner * row, *q = second->corner + 3 * corner * other;
    return (struct two_vectors){d2_load(p, q), d2_load(p + row, q + other), d2_load(p + 2 * row, q + 2 * other)};
}

/* One vector, whose coordinates are `step` floats apart, for both. */
MLRT_INLINE struct two_vectors load_twice(const float *p, size_t step)
{
    return (struct two_vectors){d2_load1(p), d2_load1(p + step), d2_load1(p + 2 * step)};
}

MLRT_INLINE struct two_vectors subtract_two(struct two_vectors v, struct two_vectors w)
{
    return (struct two_vectors){d2_sub(v.x, w.x), d2_sub(v.y, w.y), d2_sub(v.z, w.z)};
}

MLRT_INLINE struct two_vectors magnitudes_of_two(struct two_vectors v)
{
    return (struct two_vectors){d2_abs(v.x), d2_abs(v.y), d2_abs(v.z)};
}

MLRT_INLINE d2 sum_two(struct two_vectors v)
{
    return d2_add(d2_add(v.x, v.y), v.z);
}

MLRT_INLINE struct two_vectors cross_two(struct two_vectors v, struct two_vectors w)
{
    return (struct two_vectors){d2_sub(d2_mul(v.y, w.z), d2_mul(v.z, w.y)), d2_sub(d2_mul(v.z, w.x), d2_mul(v.x, w.z)),
                                d2_sub(d2_mul(v.x, w.y), d2_mul(v.y, w.x))};
}

MLRT_INLINE d2 dot_two(struct two_vectors v, struct two_vectors w)
{
    return d2_add(d2_add(d2_mul(v.x, w.x), d2_mul(v.y, w.y)), d2_mul(v.z, w.z));
}

/*
 * Do both triangles lie in one plane across an axis? Along it, sides have these sizes, and corners a lie at `a`. Floats
 * are multiples of 2^-149. If one triangle is odd (bvh/unit.c), `a` is a NaN, and so is the greatest of the sizes.
 */
MLRT_INLINE int share_plane_across(d2 ab_size, d2 ac_size, d2 a)
{
    return d2_gt(d2_set1(0x1p-150), d2_max(d2_max(ab_size, ac_size), d2_abs(d2_sub(a, d2_swap(a))))) == 3;
}

/*
 * Does a ray hit `first` before `second`, if it surely hits both? 1 or 0; -1 if double cannot tell. Of triangles in one
 * plane across an axis, it returns `wins_tie`, which is 0 or 1. Only uncertain answers take a branch, so callers that
 * use the result without one do not wait for it. `origin` and `along` are those of the ray, twice.
 */
MLRT_INLINE int comes_first(struct two_vectors origin, struct two_vectors along, const struct mlrt_corners *first,
                            const struct mlrt_corners *second, int wins_tie)
{
    const struct two_vectors a = load_two(first, second, 0);
    const struct two_vectors ab = subtract_two(load_two(first, second, 1), a),
                             ac = subtract_two(load_two(first, second, 2), a);
    const struct two_vectors to_a = subtract_two(a, origin);
    const struct two_vectors ab_sizes = magnitudes_of_two(ab), ac_sizes = magnitudes_of_two(ac);
    const struct two_vectors normal = cross_two(ab, ac);
    const d2 normal_size = d2_mul(sum_two(ab_sizes), sum_two(ac_sizes));
    const d2 d = dot_two(along, normal), n = dot_two(to_a, normal);
    const d2 d_size = d2_mul(sum_two(magnitudes_of_two(along)), normal_size),
             n_size = d2_mul(sum_two(magnitudes_of_two(to_a)), normal_size);
    const d2 products = d2_mul(n, d2_swap(d)), sizes = d2_mul(n_size, d2_swap(d_size));
    const double order = d2_first(d2_sub(products, d2_swap(products)));
    const double bound = MLRT_ORDER_ERROR * d2_first(d2_add(sizes, d2_swap(sizes)));
    const double later = order * copysign(1, d2_first(d2_mul(d, d2_swap(d))));
    const int is_tie = share_plane_across(ab_sizes.x, ac_sizes.x, a.x) |
                       share_plane_across(ab_sizes.y, ac_sizes.y, a.y) |
                       share_plane_across(ab_sizes.z, ac_sizes.z, a.z);
    const int are_steep = d2_gt(d2_abs(d), d2_mul(d2_set1(MLRT_LEAST_DENOMINATOR), d_size)) == 3;
    const int known = is_tie | ((fabs(later) > bound) & are_steep);
    if (!known) return -1;
    return (is_tie & wins_tie) | ((is_tie ^ 1) & (later < 0));
}

#endif
