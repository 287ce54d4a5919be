/* SPDX-License-Identifier: MIT */
/*
 * The vocabulary of the kernels, one lane wide and in plain C: what every other simd_*.h must mean lane by lane.
 *
 *   vf floats, vi 32-bit integers, vm masks; VW lanes; ALL_LANES has a bit for each. Loads and stores are aligned to the width.
 *   v_min and v_max return their second operand if either is a NaN; comparisons with a NaN are false.
 *   A mask lane is all ones or all zeros; m_bits has lane i in bit i.
 */
#ifndef MLRT_SIMD_SCALAR_H
#define MLRT_SIMD_SCALAR_H

#include <string.h>

#include "platform.h"

#define VW 1
#define ALL_LANES 1u
typedef float vf;
typedef uint32_t vi;
typedef uint32_t vm;

/* clang-format off: a table of words */
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
MLRT_INLINE void v_store(float *p, vf a) { *p = a; }
MLRT_INLINE vf v_add(vf a, vf b) { return a + b; }
MLRT_INLINE vf v_sub(vf a, vf b) { return a - b; }
MLRT_INLINE vf v_mul(vf a, vf b) { return a * b; }
MLRT_INLINE vf v_div(vf a, vf b) { return a / b; }
MLRT_INLINE vf v_min(vf a, vf b) { return a < b ? a : b; }
MLRT_INLINE vf v_max(vf a, vf b) { return a > b ? a : b; }
MLRT_INLINE vf v_abs(vf a) { return float_of(bits_of(a) & 0x7FFFFFFFu); }
/* a with its sign flipped where b is negative */
MLRT_INLINE vf v_flip(vf a, vf b) { return float_of(bits_of(a) ^ (bits_of(b) & 0x80000000u)); }
MLRT_INLINE float v_hmin(vf a) { return a; }
MLRT_INLINE float v_hmax(vf a) { return a; }

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

/* Four floats, whatever VW is: the three corners or edges of a triangle, and a fourth. */
typedef struct { float x[4]; } f4;
MLRT_INLINE f4 f4_set1(float a) { return (f4){{a, a, a, a}}; }
MLRT_INLINE void f4_store(float *p, f4 a) { memcpy(p, a.x, sizeof a.x); } /* aligned to 16 bytes */
MLRT_INLINE f4 f4_add(f4 a, f4 b) { return (f4){{a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2], a.x[3] + b.x[3]}}; }
MLRT_INLINE f4 f4_sub(f4 a, f4 b) { return (f4){{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2], a.x[3] - b.x[3]}}; }
MLRT_INLINE f4 f4_mul(f4 a, f4 b) { return (f4){{a.x[0] * b.x[0], a.x[1] * b.x[1], a.x[2] * b.x[2], a.x[3] * b.x[3]}}; }
MLRT_INLINE f4 f4_div(f4 a, f4 b) { return (f4){{a.x[0] / b.x[0], a.x[1] / b.x[1], a.x[2] / b.x[2], a.x[3] / b.x[3]}}; }
MLRT_INLINE f4 f4_abs(f4 a) { return (f4){{v_abs(a.x[0]), v_abs(a.x[1]), v_abs(a.x[2]), v_abs(a.x[3])}}; }
MLRT_INLINE f4 f4_flip(f4 a, float b) { return (f4){{v_flip(a.x[0], b), v_flip(a.x[1], b), v_flip(a.x[2], b), v_flip(a.x[3], b)}}; }
/* a where b >= c, else 0 */
MLRT_INLINE f4 f4_where_ge(f4 a, f4 b, f4 c) { return (f4){{b.x[0] >= c.x[0] ? a.x[0] : 0, b.x[1] >= c.x[1] ? a.x[1] : 0, b.x[2] >= c.x[2] ? a.x[2] : 0, b.x[3] >= c.x[3] ? a.x[3] : 0}}; }
/* 1, 2, 0, 1 of a */
MLRT_INLINE f4 f4_next(f4 a) { return (f4){{a.x[1], a.x[2], a.x[0], a.x[1]}}; }
/* 0, 1, 2 of a, and 2 of b */
MLRT_INLINE f4 f4_join(f4 a, f4 b) { return (f4){{a.x[0], a.x[1], a.x[2], b.x[2]}}; }
MLRT_INLINE float f4_last(f4 a) { return a.x[3]; }
MLRT_INLINE float f4_hmin(f4 a) { return v_min(v_min(a.x[0], a.x[1]), v_min(a.x[2], a.x[3])); }
MLRT_INLINE float f4_hmax(f4 a) { return v_max(v_max(a.x[0], a.x[1]), v_max(a.x[2], a.x[3])); }
/* From three corners of three coordinates each: corner[k] has those along axis k, of a, b, c and a. */
MLRT_INLINE void f4_corners(const float v[3][3], f4 corner[3])
{
    for (int k = 0; k < 3; ++k) corner[k] = (f4){{v[0][k], v[1][k], v[2][k], v[0][k]}};
}

MLRT_INLINE vi i_set1(uint32_t a) { return a; }
MLRT_INLINE vi i_load(const uint32_t *p) { return *p; }
MLRT_INLINE void i_store(uint32_t *p, vi a) { *p = a; }
MLRT_INLINE vm i_eq(vi a, vi b) { return a == b ? 0xFFFFFFFFu : 0; }
MLRT_INLINE vi i_select(vm m, vi a, vi b) { return m ? a : b; }

#endif
