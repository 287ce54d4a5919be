/* SPDX-License-Identifier: MIT */
/*
 * Four doubles, for the numbers of one ray's hit: the first lanes of a vector of doubles where it has so many. The
 * words in plain C say what each means.
 *
 * With AVX-512 the other half of a vector is computed as well. Half vectors would be slower between whole ones: while
 * there are whole ones, Intel's processors compute halves with one unit, not two (docs/tried.md, "What paid").
 */
#ifndef MLRT_DOUBLE_QUAD_H
#define MLRT_DOUBLE_QUAD_H

#include "simd/simd.h"

#if DW >= 4

typedef vd d4;
#if DW == 8
MLRT_INLINE d4 quad_of_doubles(__m256d a) { return _mm512_castpd256_pd512(a); }
MLRT_INLINE __m256d doubles_of_quad(d4 a) { return _mm512_castpd512_pd256(a); }
#define PERMUTE _mm512_permutex_pd
#else
MLRT_INLINE d4 quad_of_doubles(__m256d a) { return a; }
MLRT_INLINE __m256d doubles_of_quad(d4 a) { return a; }
#define PERMUTE _mm256_permute4x64_pd
#endif
MLRT_INLINE d4 d4_corner_terms(const float *a, const float *o, const float *c, const float *d, const float *b)
{
    const f4 lower = _mm_blend_ps(_mm_broadcast_ss(o), _mm_broadcast_ss(c), 2);
    const d4 from = d_of_quad(_mm_blend_ps(lower, _mm_broadcast_ss(b), 8));
    const d4 differences = d_sub(d_of_quad(_mm_broadcast_ss(a)), from), direction = d_of_quad(_mm_broadcast_ss(d));
    return quad_of_doubles(_mm256_blend_pd(doubles_of_quad(differences), doubles_of_quad(direction), 4));
}
MLRT_INLINE d4 d4_set1(double a) { return d_set1(a); }
MLRT_INLINE d4 d4_add(d4 a, d4 b) { return d_add(a, b); }
MLRT_INLINE d4 d4_sub(d4 a, d4 b) { return d_sub(a, b); }
MLRT_INLINE d4 d4_mul(d4 a, d4 b) { return d_mul(a, b); }
MLRT_INLINE d4 d4_mul_add(d4 a, d4 b, d4 c) { return d_mul_add(a, b, c); }
MLRT_INLINE d4 d4_mul_sub(d4 a, d4 b, d4 c) { return d_mul_sub(a, b, c); }
MLRT_INLINE d4 d4_abs(d4 a) { return d_abs(a); }
MLRT_INLINE d4 d4_lower(d4 a) { return PERMUTE(a, _MM_SHUFFLE(0, 1, 0, 1)); }
MLRT_INLINE d4 d4_upper(d4 a) { return PERMUTE(a, _MM_SHUFFLE(2, 3, 2, 3)); }
MLRT_INLINE d4 d4_inverse(d4 a)
{
    const __m256d third = doubles_of_quad(PERMUTE(a, _MM_SHUFFLE(2, 2, 2, 2)));
    return quad_of_doubles(_mm256_div_pd(_mm256_setr_pd(1, 1, 1, -1), third));
}
MLRT_INLINE double d4_first(d4 a) { return _mm256_cvtsd_f64(doubles_of_quad(a)); }
MLRT_INLINE int d4_third_gt(d4 a, d4 b) { return d_gt(a, b) >> 2 & 1; }
MLRT_INLINE int d4_round(d4 a, d4 b, float *rounded)
{
    const f4 first = f4_add(quad_of_d(a), f4_set1(0)), second = quad_of_d(b);
    _mm_storel_pi((void *)rounded, first);
    rounded[2] = _mm_cvtss_f32(_mm_permute_ps(first, 3));
    return (_mm_movemask_ps(_mm_cmpeq_ps(first, second)) & 11) == 11;
}
#undef PERMUTE

#else

typedef struct {
    double x, y, z, w;
} d4;
/* *a - *o, *a - *c, *d, *a - *b */
MLRT_INLINE d4 d4_corner_terms(const float *a, const float *o, const float *c, const float *d, const float *b)
{
    return (d4){(double)*a - (double)*o, (double)*a - (double)*c, *d, (double)*a - (double)*b};
}
MLRT_INLINE d4 d4_set1(double a) { return (d4){a, a, a, a}; }
MLRT_INLINE d4 d4_add(d4 a, d4 b) { return (d4){a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
MLRT_INLINE d4 d4_sub(d4 a, d4 b) { return (d4){a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w}; }
MLRT_INLINE d4 d4_mul(d4 a, d4 b) { return (d4){a.x * b.x, a.y * b.y, a.z * b.z, a.w * b.w}; }
/* a b + c, and a b - c; they may have one rounding or two */
MLRT_INLINE d4 d4_mul_add(d4 a, d4 b, d4 c) { return d4_add(d4_mul(a, b), c); }
MLRT_INLINE d4 d4_mul_sub(d4 a, d4 b, d4 c) { return d4_sub(d4_mul(a, b), c); }
MLRT_INLINE d4 d4_abs(d4 a) { return (d4){fabs(a.x), fabs(a.y), fabs(a.z), fabs(a.w)}; }
/* lanes 1, 0, 1, 0 of a; lanes 3, 2, 3, 2; the first lane */
MLRT_INLINE d4 d4_lower(d4 a) { return (d4){a.y, a.x, a.y, a.x}; }
MLRT_INLINE d4 d4_upper(d4 a) { return (d4){a.w, a.z, a.w, a.z}; }
MLRT_INLINE double d4_first(d4 a) { return a.x; }
/* 1 over lane 2 of a; the opposite in the last lane */
MLRT_INLINE d4 d4_inverse(d4 a)
{
    const double inverse = 1 / a.z;
    return (d4){inverse, inverse, inverse, -inverse};
}
/* is lane 2 of a greater than that of b? */
MLRT_INLINE int d4_third_gt(d4 a, d4 b) { return a.z > b.z; }
/* rounds lanes 0, 1 and 3 of a to floats, 0 for -0; returns whether those of b are the same floats */
MLRT_INLINE int d4_round(d4 a, d4 b, float *rounded)
{
    rounded[0] = (float)a.x + 0.0f, rounded[1] = (float)a.y + 0.0f, rounded[2] = (float)a.w + 0.0f;
    return rounded[0] == (float)b.x && rounded[1] == (float)b.y && rounded[2] == (float)b.w;
}

#endif

#endif
