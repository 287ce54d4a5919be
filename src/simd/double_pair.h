/* SPDX-License-Identifier: MIT */
/*
 * Two doubles, for code that computes the same of two things: the first lanes of a vector of doubles where it has so
 * many. The words in plain C say what each means. No product and sum become one operation.
 */
#ifndef MLRT_DOUBLE_PAIR_H
#define MLRT_DOUBLE_PAIR_H

#include "simd/simd.h"

#if DW >= 2

typedef vd d2;
#ifdef WIDE
MLRT_INLINE d2 d2_load(const float *p, const float *q) { return d_of_quad(_mm_setr_ps(*p, *q, 0, 0)); }
MLRT_INLINE d2 d2_swap(d2 a) { return WIDE(shuffle_pd)(a, a, 1); }
MLRT_INLINE double d2_first(d2 a) { return WIDE(cvtsd_f64)(a); }
#else
MLRT_INLINE d2 d2_load(const float *p, const float *q) { return vcvt_f64_f32(vld1_lane_f32(q, vld1_dup_f32(p), 1)); }
MLRT_INLINE d2 d2_swap(d2 a) { return vextq_f64(a, a, 1); }
MLRT_INLINE double d2_first(d2 a) { return vgetq_lane_f64(a, 0); }
#endif
MLRT_INLINE d2 d2_set1(double a) { return d_set1(a); }
MLRT_INLINE d2 d2_load1(const float *p) { return d_set1((double)*p); }
MLRT_INLINE d2 d2_add(d2 a, d2 b) { return d_add(a, b); }
MLRT_INLINE d2 d2_sub(d2 a, d2 b) { return d_sub(a, b); }
MLRT_INLINE d2 d2_mul(d2 a, d2 b) { return d_mul(a, b); }
MLRT_INLINE d2 d2_max(d2 a, d2 b) { return d_max(a, b); }
MLRT_INLINE d2 d2_abs(d2 a) { return d_abs(a); }
MLRT_INLINE unsigned d2_gt(d2 a, d2 b) { return d_gt(a, b) & 3; }

#else

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
MLRT_INLINE d2 d2_max(d2 a, d2 b) { return (d2){d_max(a.first, b.first), d_max(a.second, b.second)}; }
MLRT_INLINE d2 d2_abs(d2 a) { return (d2){fabs(a.first), fabs(a.second)}; }
MLRT_INLINE d2 d2_swap(d2 a) { return (d2){a.second, a.first}; }
MLRT_INLINE double d2_first(d2 a) { return a.first; }
/* Where a is greater: bit 0 for the first, bit 1 for the second. */
MLRT_INLINE unsigned d2_gt(d2 a, d2 b) { return (unsigned)(a.first > b.first) | (unsigned)(a.second > b.second) << 1; }

#endif

#endif
