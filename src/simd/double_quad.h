/* SPDX-License-Identifier: MIT */
/* Four doubles, for the numbers of one ray's hit. The words in plain C say what each means. */
#ifndef MLRT_DOUBLE_QUAD_H
#define MLRT_DOUBLE_QUAD_H

#include "simd/simd.h"

#if VW >= 8

typedef __m256d d4;
MLRT_INLINE __m128 words_at(const float *const p[4])
{
    const __m128 lower = _mm_blend_ps(_mm_broadcast_ss(p[0]), _mm_broadcast_ss(p[1]), 2);
    return _mm_blend_ps(lower, _mm_blend_ps(_mm_broadcast_ss(p[2]), _mm_broadcast_ss(p[3]), 8), 12);
}
MLRT_INLINE d4 d4_differences(const float *const p[4], const float *const q[4])
{
    return _mm256_sub_pd(_mm256_cvtps_pd(words_at(p)), _mm256_cvtps_pd(words_at(q)));
}
MLRT_INLINE d4 d4_set1(double a) { return _mm256_set1_pd(a); }
MLRT_INLINE d4 d4_add(d4 a, d4 b) { return _mm256_add_pd(a, b); }
MLRT_INLINE d4 d4_mul(d4 a, d4 b) { return _mm256_mul_pd(a, b); }
MLRT_INLINE d4 d4_div(d4 a, d4 b) { return _mm256_div_pd(a, b); }
MLRT_INLINE d4 d4_mul_add(d4 a, d4 b, d4 c) { return _mm256_fmadd_pd(a, b, c); }
MLRT_INLINE d4 d4_mul_sub(d4 a, d4 b, d4 c) { return _mm256_fmsub_pd(a, b, c); }
MLRT_INLINE d4 d4_minus_mul(d4 a, d4 b, d4 c) { return _mm256_fnmadd_pd(b, c, a); }
MLRT_INLINE d4 d4_abs(d4 a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
MLRT_INLINE d4 d4_lower(d4 a) { return _mm256_permute4x64_pd(a, _MM_SHUFFLE(0, 1, 0, 1)); }
MLRT_INLINE d4 d4_upper(d4 a) { return _mm256_permute4x64_pd(a, _MM_SHUFFLE(2, 3, 2, 3)); }
MLRT_INLINE d4 d4_third(d4 a) { return _mm256_permute4x64_pd(a, _MM_SHUFFLE(2, 2, 2, 2)); }
MLRT_INLINE double d4_first(d4 a) { return _mm256_cvtsd_f64(a); }
MLRT_INLINE int d4_third_gt(d4 a, d4 b) { return _mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_GT_OQ)) >> 2 & 1; }
MLRT_INLINE int d4_round(d4 a, d4 b, float *rounded)
{
    const __m128 first = _mm256_cvtpd_ps(a), second = _mm256_cvtpd_ps(b);
    _mm_storel_pi((void *)rounded, first);
    rounded[2] = _mm_cvtss_f32(_mm_permute_ps(first, 3));
    return (_mm_movemask_ps(_mm_cmpeq_ps(first, second)) & 11) == 11;
}

#else

typedef struct {
    double x, y, z, w;
} d4;
/* p[i][0] - q[i][0] */
MLRT_INLINE d4 d4_differences(const float *const p[4], const float *const q[4])
{
    return (d4){(double)*p[0] - (double)*q[0], (double)*p[1] - (double)*q[1], (double)*p[2] - (double)*q[2],
                (double)*p[3] - (double)*q[3]};
}
MLRT_INLINE d4 d4_set1(double a) { return (d4){a, a, a, a}; }
MLRT_INLINE d4 d4_add(d4 a, d4 b) { return (d4){a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
MLRT_INLINE d4 d4_mul(d4 a, d4 b) { return (d4){a.x * b.x, a.y * b.y, a.z * b.z, a.w * b.w}; }
MLRT_INLINE d4 d4_div(d4 a, d4 b) { return (d4){a.x / b.x, a.y / b.y, a.z / b.z, a.w / b.w}; }
/* a b + c, a b - c, and a - b c; they may have one rounding or two */
MLRT_INLINE d4 d4_mul_add(d4 a, d4 b, d4 c) { return d4_add(d4_mul(a, b), c); }
MLRT_INLINE d4 d4_minus_mul(d4 a, d4 b, d4 c)
{
    return (d4){a.x - b.x * c.x, a.y - b.y * c.y, a.z - b.z * c.z, a.w - b.w * c.w};
}
MLRT_INLINE d4 d4_mul_sub(d4 a, d4 b, d4 c)
{
    return (d4){a.x * b.x - c.x, a.y * b.y - c.y, a.z * b.z - c.z, a.w * b.w - c.w};
}
MLRT_INLINE d4 d4_abs(d4 a) { return (d4){fabs(a.x), fabs(a.y), fabs(a.z), fabs(a.w)}; }
/* lanes 1, 0, 1, 0 of a; lanes 3, 2, 3, 2; lane 2 in all lanes; the first lane */
MLRT_INLINE d4 d4_lower(d4 a) { return (d4){a.y, a.x, a.y, a.x}; }
MLRT_INLINE d4 d4_upper(d4 a) { return (d4){a.w, a.z, a.w, a.z}; }
MLRT_INLINE d4 d4_third(d4 a) { return d4_set1(a.z); }
MLRT_INLINE double d4_first(d4 a) { return a.x; }
/* is lane 2 of a greater than that of b? */
MLRT_INLINE int d4_third_gt(d4 a, d4 b) { return a.z > b.z; }
/* rounds lanes 0, 1 and 3 of a to floats; returns whether those of b are the same floats */
MLRT_INLINE int d4_round(d4 a, d4 b, float *rounded)
{
    rounded[0] = (float)a.x, rounded[1] = (float)a.y, rounded[2] = (float)a.w;
    return rounded[0] == (float)b.x && rounded[1] == (float)b.y && rounded[2] == (float)b.w;
}

#endif

#endif
