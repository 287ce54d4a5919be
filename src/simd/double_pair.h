/* SPDX-License-Identifier: MIT */
/* Two doubles, for code that computes the same of two things. No product and sum become one operation. */
#ifndef MLRT_DOUBLE_PAIR_H
#define MLRT_DOUBLE_PAIR_H

#include "base/platform.h"

#if MLRT_SSE_KERNELS
#include <emmintrin.h>

typedef __m128d d2;
MLRT_INLINE d2 d2_set1(double a) { return _mm_set1_pd(a); }
MLRT_INLINE d2 d2_load(const float *p, const float *q) { return _mm_cvtps_pd(_mm_setr_ps(*p, *q, 0, 0)); }
MLRT_INLINE d2 d2_load1(const float *p) { return _mm_cvtps_pd(_mm_set1_ps(*p)); }
MLRT_INLINE d2 d2_add(d2 a, d2 b) { return _mm_add_pd(a, b); }
MLRT_INLINE d2 d2_sub(d2 a, d2 b) { return _mm_sub_pd(a, b); }
MLRT_INLINE d2 d2_mul(d2 a, d2 b) { return _mm_mul_pd(a, b); }
MLRT_INLINE d2 d2_abs(d2 a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a); }
MLRT_INLINE d2 d2_swap(d2 a) { return _mm_shuffle_pd(a, a, 1); }
MLRT_INLINE double d2_first(d2 a) { return _mm_cvtsd_f64(a); }
MLRT_INLINE d2 d2_either(d2 a, d2 b) { return _mm_or_pd(a, b); }
MLRT_INLINE int d2_zero(d2 a) { return _mm_movemask_pd(_mm_cmpeq_pd(a, _mm_setzero_pd())) == 3; }
MLRT_INLINE int d2_gt(d2 a, d2 b) { return _mm_movemask_pd(_mm_cmpgt_pd(a, b)) == 3; }
#elif MLRT_NEON_KERNELS
#include <arm_neon.h>

typedef float64x2_t d2;
MLRT_INLINE d2 d2_set1(double a) { return vdupq_n_f64(a); }
MLRT_INLINE d2 d2_load(const float *p, const float *q) { return vcvt_f64_f32(vld1_lane_f32(q, vld1_dup_f32(p), 1)); }
MLRT_INLINE d2 d2_load1(const float *p) { return vcvt_f64_f32(vld1_dup_f32(p)); }
MLRT_INLINE d2 d2_add(d2 a, d2 b) { return vaddq_f64(a, b); }
MLRT_INLINE d2 d2_sub(d2 a, d2 b) { return vsubq_f64(a, b); }
MLRT_INLINE d2 d2_mul(d2 a, d2 b) { return vmulq_f64(a, b); }
MLRT_INLINE d2 d2_abs(d2 a) { return vabsq_f64(a); }
MLRT_INLINE d2 d2_swap(d2 a) { return vextq_f64(a, a, 1); }
MLRT_INLINE double d2_first(d2 a) { return vgetq_lane_f64(a, 0); }
MLRT_INLINE d2 d2_either(d2 a, d2 b)
{
    return vreinterpretq_f64_u64(vorrq_u64(vreinterpretq_u64_f64(a), vreinterpretq_u64_f64(b)));
}
MLRT_INLINE int both_of(uint64x2_t a) { return vminvq_u32(vreinterpretq_u32_u64(a)) != 0; }
MLRT_INLINE int d2_zero(d2 a) { return both_of(vceqzq_f64(a)); }
MLRT_INLINE int d2_gt(d2 a, d2 b) { return both_of(vcgtq_f64(a, b)); }
#else
#include <math.h>

typedef struct {
    double first, second;
} d2;
/* Both are a. */
MLRT_INLINE d2 d2_set1(double a) { return (d2){a, a}; }
MLRT_INLINE d2 d2_load(const float *p, const float *q) { return (d2){*p, *q}; }
MLRT_INLINE d2 d2_load1(const float *p) { return (d2){*p, *p}; }
MLRT_INLINE d2 d2_add(d2 a, d2 b) { return (d2){a.first + b.first, a.second + b.second}; }
MLRT_INLINE d2 d2_sub(d2 a, d2 b) { return (d2){a.first - b.first, a.second - b.second}; }
MLRT_INLINE d2 d2_mul(d2 a, d2 b) { return (d2){a.first * b.first, a.second * b.second}; }
MLRT_INLINE d2 d2_abs(d2 a) { return (d2){fabs(a.first), fabs(a.second)}; }
MLRT_INLINE d2 d2_swap(d2 a) { return (d2){a.second, a.first}; }
MLRT_INLINE double d2_first(d2 a) { return a.first; }
/* 0 where both vectors are, and else not. */
MLRT_INLINE d2 d2_either(d2 a, d2 b) { return (d2){a.first != 0 || b.first != 0, a.second != 0 || b.second != 0}; }
/* Are both 0? Are both of a greater? */
MLRT_INLINE int d2_zero(d2 a) { return (a.first == 0) & (a.second == 0); }
MLRT_INLINE int d2_gt(d2 a, d2 b) { return (a.first > b.first) & (a.second > b.second); }
#endif

#endif
