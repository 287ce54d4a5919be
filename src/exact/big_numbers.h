/* SPDX-License-Identifier: MIT */
/*
 * Exact arithmetic on dyadic numbers (integers times a power of two), for the decisions that double cannot make.
 *
 * Sums, differences and products are exact. There is no division and no rounding, and nothing is allocated: a number
 * has room for the largest value of the hit rule. It uses only the 32-bit limbs between its highest and its lowest bit:
 * a few limbs for ordinary coordinates, so that an operation takes a few nanoseconds.
 *
 * How many limbs. A coordinate of a vertex, origin or direction and a t are multiples of 2^-149 below 2^128, and a
 * difference of two is below 2^129.
 *
 *   - A component of n = (b - a) x (c - a) is twice an area within a square of side 2^129, so at most 2^258. Hence
 *     D = d . n and N = (a - o) . n, with every product and partial sum on the way, are multiples of 2^-447 below
 *     3 * 2^387 < 2^389. So is e_ij = (d x (v_i - o)) . (v_j - v_i), where a component of the cross product is at most
 *     2^258. They take limb positions -14 .. 12 (bits -448 .. 415): 27 limbs.
 *   - The order test N1 D2 - N2 D1: a product of two such numbers is written into 27 + 27 = 54 limbs. The difference,
 *     2^-894 .. 2^780, needs 53.
 *   - The interval test N - t D and the rounding test N - m D, where m lies midway between two floats and is a multiple
 *     of 2^-150 of 25 bits: 2^-597 .. 2^518, 35 limbs.
 *
 * Every operation asserts that its result fits.
 */
#ifndef MLRT_EXACT_BIG_NUMBERS_H
#define MLRT_EXACT_BIG_NUMBERS_H

#include <stdint.h>

#include "mlrt.h"

#define MLRT_EXACT_DETERMINANT_LIMBS 27
#define MLRT_EXACT_LIMBS             (2 * MLRT_EXACT_DETERMINANT_LIMBS)

/*
 * The number sign * sum of limb[i] 2^(32 (position + i)), i < count. The first and the last limb are not 0, so each
 * value has one form. Zero has sign = 0, count = 0, position = 0.
 */
struct mlrt_exact {
    int32_t sign; /* -1, 0, 1 */
    int32_t position;
    int32_t count;
    uint32_t limb[MLRT_EXACT_LIMBS];
};

/* The value of any finite double (and so of any finite float), denormal or not. -0 becomes 0. */
void mlrt_exact_from_double(double value, struct mlrt_exact *result);

/* first - second, for finite floats. */
void mlrt_exact_from_difference(float first, float second, struct mlrt_exact *result);

/* Sum, difference, product. `result` must not be an operand. */
void mlrt_exact_add(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result);
void mlrt_exact_subtract(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result);
void mlrt_exact_multiply(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result);

/* The sign of |first| - |second|. */
int mlrt_exact_compare_magnitude(const struct mlrt_exact *first, const struct mlrt_exact *second);

/* The number as a double, with a relative error below 2^-51. It must be 0 or of magnitude 2^-900 .. 2^900. */
double mlrt_exact_to_double(const struct mlrt_exact *number);

#endif
