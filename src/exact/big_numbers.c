/* SPDX-License-Identifier: MIT */
/*
 * Exact arithmetic on dyadic numbers: the schoolbook methods on 32-bit limbs, whose products fit uint64_t.
 *
 * Limbs start at fixed positions (bit 32 k, for integer k): so only a conversion shifts bits, and sums need not.
 *
 * Based on: Donald E. Knuth, "The Art of Computer Programming", volume 2, 1997, section 4.3.1 (algorithms A, S, M);
 * for the difference of two floats, the same, section 4.2.2, theorem B.
 */
#include "exact/big_numbers.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Restores the form after an operation: no zero limbs at either end, and zero as one value. */
static void normalize(struct mlrt_exact *number)
{
    int32_t count = number->count;
    int32_t low = 0;
    while (count > 0 && number->limb[count - 1] == 0) --count;
    while (low < count && number->limb[low] == 0) ++low;
    if (low > 0) memmove(number->limb, number->limb + low, (size_t)(count - low) * sizeof number->limb[0]);
    number->count = count - low;
    number->position += low;
    if (number->count == 0) {
        number->sign = 0;
        number->position = 0;
    }
}

void mlrt_exact_from_double(double value, struct mlrt_exact *result)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t biased_exponent = (uint32_t)(bits >> 52) & 0x7FF;
    uint64_t mantissa = bits & 0xFFFFFFFFFFFFFu;
    assert(biased_exponent != 0x7FF);
    if (biased_exponent == 0) {
        biased_exponent = 1; // a denormal (or 0) has the least exponent and no hidden bit
    } else {
        mantissa |= (uint64_t)1 << 52;
    }

    // |value| = mantissa * 2^(biased_exponent - 1075), and 1075 = 34 * 32 - 13.
    uint32_t exponent = biased_exponent + 13;
    uint32_t shift = exponent % 32;
    uint64_t low = (mantissa & 0xFFFFFFFFu) << shift;
    uint64_t high = (mantissa >> 32) << shift;
    result->sign = bits >> 63 ? -1 : 1;
    result->position = (int32_t)(exponent / 32) - 34;
    result->count = 3;
    result->limb[0] = (uint32_t)low;
    result->limb[1] = (uint32_t)(low >> 32) | (uint32_t)high;
    result->limb[2] = (uint32_t)(high >> 32);
    normalize(result);
}

void mlrt_exact_from_difference(float first, float second, struct mlrt_exact *result)
{
    // The rounding error of the sum is itself a double. It is 0 unless the exponents are some 29 apart.
    double a = first, b = -(double)second;
    double sum = a + b;
    double b_part = sum - a;
    double error = (a - (sum - b_part)) + (b - b_part);
    if (error == 0) {
        mlrt_exact_from_double(sum, result);
        return;
    }
    struct mlrt_exact exact_sum, exact_error;
    mlrt_exact_from_double(sum, &exact_sum);
    mlrt_exact_from_double(error, &exact_error);
    mlrt_exact_add(&exact_sum, &exact_error, result);
}

/* The limb that starts at bit 32 * position: 0 outside the number. */
static inline uint32_t limb_at(const struct mlrt_exact *number, int32_t position)
{
    uint32_t index = (uint32_t)(position - number->position);
    return index < (uint32_t)number->count ? number->limb[index] : 0;
}

/* One past the position of the highest limb. */
static inline int32_t end_position(const struct mlrt_exact *number)
{
    return number->position + number->count;
}

int mlrt_exact_compare_magnitude(const struct mlrt_exact *first, const struct mlrt_exact *second)
{
    if (first->count == 0 || second->count == 0) return (first->count > 0) - (second->count > 0);
    int32_t end = end_position(first), second_end = end_position(second);
    if (end != second_end) return end > second_end ? 1 : -1;
    int32_t start = first->position < second->position ? first->position : second->position;
    for (int32_t position = end - 1; position >= start; --position) {
        uint32_t a = limb_at(first, position), b = limb_at(second, position);
        if (a != b) return a > b ? 1 : -1;
    }
    return 0;
}

/* |first| + factor |second|, which is not negative; factor is 1 or -1, neither operand 0. The caller sets the sign. */
static void combine_magnitudes(const struct mlrt_exact *first, const struct mlrt_exact *second, int factor,
                               struct mlrt_exact *result)
{
    int32_t start = first->position < second->position ? first->position : second->position;
    int32_t end = end_position(first) > end_position(second) ? end_position(first) : end_position(second);
    assert(end - start <= MLRT_EXACT_LIMBS);
    int64_t carry = 0;
    for (int32_t position = start; position < end; ++position) {
        const int64_t sum = (int64_t)limb_at(first, position) + factor * (int64_t)limb_at(second, position) + carry;
        result->limb[position - start] = (uint32_t)sum;
        carry = sum < 0 ? -1 : sum >> 32;
    }
    result->position = start;
    result->count = end - start;
    if (carry != 0) {
        assert(result->count < MLRT_EXACT_LIMBS);
        result->limb[result->count++] = (uint32_t)carry;
    }
    normalize(result);
}

/* first + second_sign * |second| */
static void add_signed(const struct mlrt_exact *first, const struct mlrt_exact *second, int32_t second_sign,
                       struct mlrt_exact *result)
{
    assert(result != first && result != second);
    if (second_sign == 0 || first->sign == 0) {
        *result = second_sign == 0 ? *first : *second;
        result->sign = second_sign == 0 ? first->sign : second_sign;
        return;
    }
    const int is_first = first->sign == second_sign || mlrt_exact_compare_magnitude(first, second) >= 0;
    result->sign = is_first ? first->sign : second_sign;
    combine_magnitudes(is_first ? first : second, is_first ? second : first, first->sign * second_sign, result);
}

void mlrt_exact_add(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result)
{
    add_signed(first, second, second->sign, result);
}

void mlrt_exact_subtract(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result)
{
    add_signed(first, second, -second->sign, result);
}

void mlrt_exact_multiply(const struct mlrt_exact *first, const struct mlrt_exact *second, struct mlrt_exact *result)
{
    assert(result != first && result != second);
    int32_t count = first->count + second->count;
    assert(count <= MLRT_EXACT_LIMBS);
    result->sign = first->sign * second->sign;
    result->position = first->position + second->position;
    result->count = count;
    for (int32_t i = 0; i < count; ++i) result->limb[i] = 0;
    for (int32_t i = 0; i < first->count; ++i) {
        // (2^32 - 1)^2 + 2 (2^32 - 1) = 2^64 - 1: a step cannot overflow.
        uint64_t factor = first->limb[i], carry = 0;
        uint32_t *row = result->limb + i;
        for (int32_t j = 0; j < second->count; ++j) {
            carry += factor * second->limb[j] + row[j];
            row[j] = (uint32_t)carry;
            carry >>= 32;
        }
        row[second->count] = (uint32_t)carry;
    }
    normalize(result);
}

double mlrt_exact_to_double(const struct mlrt_exact *number)
{
    // The three highest limbs have 65 bits or more, and the limbs below them are less than 2^-64 of the number. Limbs
    // are exact as doubles, both sums are rounded once each, and the power of two is exact.
    int32_t end = end_position(number);
    double low = limb_at(number, end - 3);
    double high = 4294967296.0 * limb_at(number, end - 1) + limb_at(number, end - 2);
    return number->sign * ldexp(4294967296.0 * high + low, 32 * (end - 3));
}
