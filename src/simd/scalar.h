/* SPDX-License-Identifier: MIT */
/*
 * The vocabulary of the kernels in plain C, one lane wide. It defines each word: in the other headers of this folder,
 * each lane has the same meaning.
 *
 * - vf is a vector of floats, vi of 32-bit integers, vm a mask, each with VW lanes; ALL_LANES has a bit for each lane.
 * - Addresses of loads and stores are aligned to the width, except for v_load_any and i_load_any.
 * - v_min and v_max return their second operand if either is a NaN. Comparisons with a NaN are false.
 * - A lane of a mask is true or false: all ones or all zeros of a vector, or one bit (AVX-512). m_bits has lane i in
 *   bit i.
 * - v_mul_add is a b + c, and v_mul_sub a b - c, with one rounding or two: only code with bounds for both may use them.
 * - v_hmin is the least lane of a vector, v_hmax the greatest; v_hmin4 has the least lanes of four vectors.
 * - vd is a vector of DW doubles, which are loaded from floats, and rounded to floats when stored. d_mul_add and
 *   d_mul_sub have one rounding or two, like v_mul_add. In the bits of d_gt, lane i is bit i.
 * - v_store_rows stores the words of four packets side by side: four rows of sixteen, `row_stride` bytes apart. The
 *   words of packet i are at first + i * distance; its lanes are squares of 2x2 elements (rays/packet.h).
 * - v_triples_at, v_quads_at, v_floats_at and i_pairs_at load three, four, one or two words of each lane, one vector
 *   a word. Lanes are squares of 2x2 elements (rays/packet.h), and p is the element of the first lane. Neighbours
 *   in a row are `step` bytes apart, rows `row_step` bytes. v_triples is for a step of 12. These words read no bytes
 *   except those that they load.
 */
#ifndef MLRT_SIMD_SCALAR_H
#define MLRT_SIMD_SCALAR_H

#include <math.h>
#include <string.h>

#include "base/platform.h"
#include "simd/quad_scalar.h"

#define VW        1
#define ALL_LANES 1u
#define DW        1
typedef float vf;
typedef uint32_t vi;
typedef uint32_t vm;
typedef double vd;

MLRT_INLINE uint32_t bits_of(float a)
{
    uint32_t bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}
MLRT_INLINE float float_of(uint32_t bits)
{
    float a;
    memcpy(&a, &bits, sizeof a);
    return a;
}

MLRT_INLINE vf v_set1(float a) { return a; }
MLRT_INLINE vf v_load(const float *p) { return *p; }
MLRT_INLINE vf v_load_any(const float *p) { return *p; } /* aligned to 4 bytes */
MLRT_INLINE void v_store(float *p, vf a) { *p = a; }
MLRT_INLINE vf v_add(vf a, vf b) { return a + b; }
MLRT_INLINE vf v_sub(vf a, vf b) { return a - b; }
MLRT_INLINE vf v_mul(vf a, vf b) { return a * b; }
MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return a * b + c; }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return a * b - c; }
MLRT_INLINE vf v_div(vf a, vf b) { return a / b; }
MLRT_INLINE vf v_min(vf a, vf b) { return a < b ? a : b; }
MLRT_INLINE vf v_max(vf a, vf b) { return a > b ? a : b; }
MLRT_INLINE vf v_abs(vf a) { return float_of(bits_of(a) & 0x7FFFFFFFu); }
MLRT_INLINE vf v_opposite(vf a) { return -a; }
/* a with its sign flipped where b is negative */
MLRT_INLINE vf v_flip(vf a, vf b) { return float_of(bits_of(a) ^ (bits_of(b) & 0x80000000u)); }
MLRT_INLINE float v_hmin(vf a) { return a; }
MLRT_INLINE float v_hmax(vf a) { return a; }
MLRT_INLINE f4 v_hmin4(vf a, vf b, vf c, vf d) { return (f4){{a, b, c, d}}; }

MLRT_INLINE vm v_lt(vf a, vf b) { return a < b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vm v_le(vf a, vf b) { return a <= b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vm v_gt(vf a, vf b) { return a > b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vm v_ge(vf a, vf b) { return a >= b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vm v_eq(vf a, vf b) { return a == b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vf v_select(vm m, vf a, vf b) { return m ? a : b; }

MLRT_INLINE vm m_and(vm a, vm b) { return a & b; }
MLRT_INLINE vm m_or(vm a, vm b) { return a | b; }
/* a and not b */
MLRT_INLINE vm m_andnot(vm a, vm b) { return a & ~b; }
MLRT_INLINE unsigned m_bits(vm a) { return a & 1; }
MLRT_INLINE vm m_from_bits(unsigned bits) { return (bits & 1) ? 0xFFFFFFFFu : 0; }

MLRT_INLINE vi i_set1(uint32_t a) { return a; }
MLRT_INLINE vi i_load(const uint32_t *p) { return *p; }
MLRT_INLINE vi i_load_any(const uint32_t *p) { return *p; } /* aligned to 4 bytes */
MLRT_INLINE void i_store(uint32_t *p, vi a) { *p = a; }
MLRT_INLINE vi i_sub(vi a, vi b) { return a - b; }
MLRT_INLINE vi i_and(vi a, vi b) { return a & b; }
/* as unsigned numbers */
MLRT_INLINE vm i_lt(vi a, vi b) { return a < b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vm i_eq(vi a, vi b) { return a == b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vi i_select(vm m, vi a, vi b) { return m ? a : b; }

MLRT_INLINE void v_triples_at(const unsigned char *p, size_t step, size_t row_step, vf by_axis[3])
{
    (void)step, (void)row_step;
    for (int k = 0; k < 3; ++k) memcpy(&by_axis[k], p + 4 * k, 4);
}
MLRT_INLINE void v_quads_at(const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    (void)step, (void)row_step;
    for (int k = 0; k < 4; ++k) memcpy(&by_word[k], p + 4 * k, 4);
}
MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    v_triples_at(p, 12, row_step, by_axis);
}
MLRT_INLINE vf v_floats_at(const unsigned char *p, size_t step, size_t row_step)
{
    float a;
    (void)step, (void)row_step;
    memcpy(&a, p, 4);
    return a;
}
MLRT_INLINE void v_store_rows(const float *first, size_t distance, unsigned char *at, size_t row_stride)
{
    for (size_t i = 0; i < 32; ++i) { /* pairs of lanes lie side by side */
        const size_t pair = i % 8, row = (pair & 1) + 2 * (pair >> 2), column = 4 * (i / 8) + (pair & 2);
        memcpy(at + row * row_stride + 4 * column, first + i / 8 * distance + 2 * pair, 8);
    }
}
MLRT_INLINE void i_pairs_at(const unsigned char *p, size_t step, size_t row_step, vi *firsts, vi *seconds)
{
    (void)step, (void)row_step;
    memcpy(firsts, p, 4);
    memcpy(seconds, p + 4, 4);
}

MLRT_INLINE vd d_set1(double a) { return a; }
MLRT_INLINE vd d_load(const float *p) { return *p; }
MLRT_INLINE void d_store(float *p, vd a) { *p = (float)a; }
MLRT_INLINE vd d_add(vd a, vd b) { return a + b; }
MLRT_INLINE vd d_sub(vd a, vd b) { return a - b; }
MLRT_INLINE vd d_mul(vd a, vd b) { return a * b; }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return d_add(d_mul(a, b), c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return d_sub(d_mul(a, b), c); }
MLRT_INLINE vd d_div(vd a, vd b) { return a / b; }
MLRT_INLINE vd d_abs(vd a) { return fabs(a); }
/* the second if either is a NaN */
MLRT_INLINE vd d_max(vd a, vd b) { return a > b ? a : b; }
/* a with its sign flipped where b is negative */
MLRT_INLINE vd d_flip(vd a, vd b) { return copysign(a, copysign(1, a) * copysign(1, b)); }
/* bits of the lanes where a > b */
MLRT_INLINE unsigned d_gt(vd a, vd b) { return a > b; }
/* bits of the lanes where both round to one float */
MLRT_INLINE unsigned d_same_float(vd a, vd b) { return (float)a == (float)b; }

#endif
