/* SPDX-License-Identifier: MIT */
/*
 * Exact arithmetic on dyadic numbers (integers times a power of two), for the decisions that double cannot make.
 *
 * Sums, differences and products are exact; there is no division and no rounding, and nothing is allocated: a number
 * has room for the largest value that the hit rule can ask for. It occupies only the 32-bit limbs between its highest
 * and its lowest bit, so ordinary coordinates stay at a few limbs and an operation costs a few nanoseconds.
 *
 * Room. A vertex, origin, direction or t is a multiple of 2^-149 below 2^128, a difference of two is below 2^129.
 *
 *   - A component of n = (b - a) x (c - a) is twice an area within a square of side 2^129, so at most 2^258; hence
 *     D = d . n and N = (a - o) . n are multiples of 2^-447 below 3 * 2^387 < 2^389, with every product and partial sum
 *     on the way, and so is e_ij = (d x (v_i - o)) . (v_j - v_i), where a component of the cross product is at most
 *     2^258. Limb positions -14 .. 12 (bits -448 .. 415): 27 limbs.
 *   - The order test N1 D2 - N2 D1: a product of two such numbers is written into 27 + 27 = 54 limbs; the difference,
 *     2^-894 .. 2^780, needs 53.
 *   - The interval test N - t D and the rounding test N - m D, where m is midway between two floats, a multiple of
 *     2^-150 of 25 bits: 2^-597 .. 2^518, 35 limbs.
 *
 * Every operation asserts that its result fits.
 */
#ifndef MLRT_EXACT_DYADIC_H
#define MLRT_EXACT_DYADIC_H

#include <stdint.h>

#include "mlrt.h"

#define MLRT_EXACT_DETERMINANT_LIMBS 27
#define MLRT_EXACT_LIMBS             (2 * MLRT_EXACT_DETERMINANT_LIMBS)

/*
 * sign * sum of limb[i] 2^(32 (position + i)), i < count. The first and the last limb are not 0, so each value has one
 * form; zero is sign = 0, count = 0, position = 0.
 */
struct mlrt_exact {
    int32_t sign; /* -1, 0, 1 */
    int32_t position;
    int32_t count;
    uint32_t limb[MLRT_EXACT_LIMBS];
};

/* Any finite double, and so any finite float; denormals too. -0 is 0. */
void mlrt_exact_from_double(double value, struct mlrt_exact *result);

/* first - second, for finite floats. */
void mlrt_exact_from_difference(float first, float second, struct mlrt_exact *result);

/* In these `result` must not be an operand. */
void mlrt_exact_add(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result);
void mlrt_exact_subtract(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result);
void mlrt_exact_multiply(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result);

/* The sign of |first| - |second|. */
int mlrt_exact_compare_magnitude(const struct mlrt_exact *first, const struct mlrt_exact *second);

/* The number with a relative error below 2^-51. Its magnitude must be 0 or within 2^-900 .. 2^900. */
double mlrt_exact_to_double(const struct mlrt_exact *number);

#endif
