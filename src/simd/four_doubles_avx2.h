/* SPDX-License-Identifier: MIT */
/*
 * Four doubles in AVX2. four_doubles.h says what each word means.
 */
#ifndef MLRT_FOUR_DOUBLES_AVX2_H
#define MLRT_FOUR_DOUBLES_AVX2_H

#include <immintrin.h>
#include <stddef.h>

#include "base/platform.h"

typedef __m256d d4;
MLRT_INLINE d4 d4_set(double a, double b, double c, double d) { return _mm256_setr_pd(a, b, c, d); }
MLRT_INLINE d4 d4_lane(d4 a, int i)
{
    return i == 0 ? _mm256_broadcastsd_pd(_mm256_castpd256_pd128(a)) : _mm256_permute4x64_pd(a, 0xFF);
}
MLRT_INLINE d4 d4_three(const float *p, size_t step)
{
    const __m128 xy = _mm_insert_ps(_mm_load_ss(p), _mm_load_ss(p + step), 0x10);
    return _mm256_cvtps_pd(_mm_insert_ps(xy, _mm_load_ss(p + 2 * step), 0x20));
}
MLRT_INLINE d4 d4_next(d4 a) { return _mm256_permute4x64_pd(a, _MM_SHUFFLE(3, 0, 2, 1)); }
MLRT_INLINE d4 d4_reversed(d4 a) { return _mm256_permute4x64_pd(a, _MM_SHUFFLE(0, 1, 2, 3)); }
MLRT_INLINE d4 d4_inside_out(d4 a) { return _mm256_permute4x64_pd(a, _MM_SHUFFLE(1, 0, 0, 1)); }
MLRT_INLINE d4 d4_first_of(d4 a, d4 b) { return _mm256_blend_pd(b, a, 1); }
MLRT_INLINE d4 d4_mul(d4 a, d4 b) { return _mm256_mul_pd(a, b); }
MLRT_INLINE d4 d4_add(d4 a, d4 b) { return _mm256_add_pd(a, b); }
MLRT_INLINE d4 d4_sub(d4 a, d4 b) { return _mm256_sub_pd(a, b); }
MLRT_INLINE d4 d4_inverse(d4 a) { return _mm256_div_pd(_mm256_set1_pd(1), a); }
MLRT_INLINE d4 d4_abs(d4 a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
MLRT_INLINE d4 d4_sums(d4 a, d4 b, d4 c, d4 d)
{
    const __m256d ab = _mm256_unpacklo_pd(a, b), cd = _mm256_unpacklo_pd(c, d);
    const __m256d y =
        _mm256_insertf128_pd(_mm256_unpackhi_pd(a, b), _mm256_castpd256_pd128(_mm256_unpackhi_pd(c, d)), 1);
    const __m256d x = _mm256_insertf128_pd(ab, _mm256_castpd256_pd128(cd), 1);
    return _mm256_add_pd(_mm256_add_pd(x, y), _mm256_permute2f128_pd(ab, cd, 0x31));
}
MLRT_INLINE unsigned d4_lt(d4 a, d4 b) { return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ)); }
MLRT_INLINE unsigned d4_round(float *p, d4 a, d4 b)
{
    const __m128 rounded = _mm256_cvtpd_ps(b);
    _mm_store_ps(p, rounded);
    return (unsigned)_mm_movemask_ps(_mm_cmpeq_ps(_mm256_cvtpd_ps(a), rounded));
}

#endif
