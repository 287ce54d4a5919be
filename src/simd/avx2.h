/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in AVX2, eight lanes wide. scalar.h says what each word means. */
#ifndef MLRT_SIMD_AVX2_H
#define MLRT_SIMD_AVX2_H

#include <immintrin.h>

#include "simd/quad_sse.h"

#define VW          8
#define ALL_LANES   255u
#define DW          4
#define WIDE(name)  _mm256_##name
#define WHOLE(name) _mm256_##name##_si256
typedef __m256 vf;
typedef __m256i vi;
typedef __m256 vm;
typedef __m256d vd;

MLRT_INLINE f4 least_quad(vf a) { return _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1)); }
MLRT_INLINE f4 greatest_quad(vf a) { return _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1)); }
MLRT_INLINE vf at_quarters(quad_load *load, const unsigned char *p, size_t step, size_t row_step)
{
    return _mm256_setr_m128(load(p, step, row_step), load(p + 2 * step, step, row_step));
}
MLRT_INLINE f4 triple_at(const unsigned char *p, size_t step, size_t row_step)
{
    (void)step, (void)row_step;
    return _mm_maskload_ps((const float *)(const void *)p, _mm_setr_epi32(-1, -1, -1, 0));
}

#include "simd/intrinsics.h"

MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return _mm256_fmadd_ps(a, b, c); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return _mm256_fmsub_ps(a, b, c); }

MLRT_INLINE vm v_lt(vf a, vf b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
MLRT_INLINE vm v_le(vf a, vf b) { return _mm256_cmp_ps(a, b, _CMP_LE_OQ); }
MLRT_INLINE vm v_gt(vf a, vf b) { return _mm256_cmp_ps(a, b, _CMP_GT_OQ); }
MLRT_INLINE vm v_ge(vf a, vf b) { return _mm256_cmp_ps(a, b, _CMP_GE_OQ); }
MLRT_INLINE vm v_eq(vf a, vf b) { return _mm256_cmp_ps(a, b, _CMP_EQ_OQ); }
MLRT_INLINE vf v_select(vm m, vf a, vf b) { return _mm256_blendv_ps(b, a, m); }

MLRT_INLINE vm m_and(vm a, vm b) { return _mm256_and_ps(a, b); }
MLRT_INLINE vm m_or(vm a, vm b) { return _mm256_or_ps(a, b); }
MLRT_INLINE vm m_andnot(vm a, vm b) { return _mm256_andnot_ps(b, a); }
MLRT_INLINE unsigned m_bits(vm a) { return (unsigned)_mm256_movemask_ps(a); }
MLRT_INLINE vm m_from_bits(unsigned bits)
{
    const __m256i lanes = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)bits), lanes), lanes));
}

MLRT_INLINE vm i_lt(vi a, vi b)
{
    const __m256i flip = _mm256_set1_epi32((int)0x80000000u);
    return _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_xor_si256(b, flip), _mm256_xor_si256(a, flip)));
}
MLRT_INLINE vm i_eq(vi a, vi b) { return _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b)); }
MLRT_INLINE vi i_select(vm m, vi a, vi b) { return _mm256_blendv_epi8(b, a, _mm256_castps_si256(m)); }

/*
 * Reorders two rows of four columns, one in each half, into two squares: columns 0 and 1 of both rows, then 2 and 3. Or
 * two such squares into two rows.
 */
MLRT_INLINE vf squares_of_rows(__m256 rows)
{
    return _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(rows), _MM_SHUFFLE(3, 1, 2, 0)));
}
MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    const unsigned char *below = p + row_step;
    const __m256 a = _mm256_setr_m128(f4_load_any(p), f4_load_any(below));
    const __m256 b = _mm256_setr_m128(f4_load_any(p + 16), f4_load_any(below + 16));
    const __m256 c = _mm256_setr_m128(f4_load_any(p + 32), f4_load_any(below + 32));
    const __m256 yz = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
    const __m256 xy = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
    by_axis[0] = squares_of_rows(_mm256_shuffle_ps(a, xy, _MM_SHUFFLE(2, 0, 3, 0)));
    by_axis[1] = squares_of_rows(_mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0)));
    by_axis[2] = squares_of_rows(_mm256_shuffle_ps(yz, c, _MM_SHUFFLE(3, 0, 3, 1)));
}
MLRT_INLINE void v_store_rows(const float *first, size_t distance, unsigned char *at, size_t row_stride)
{
    for (int i = 0; i < 2; ++i, first += 8, at += 2 * row_stride) {
        __m256 rows[4]; /* of each packet, one in each half */
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) rows[k] = squares_of_rows(_mm256_load_ps(first + k * distance));
        MLRT_UNROLL
        for (int k = 0; k < 4; k += 2)
            _mm256_storeu_ps((void *)(at + 16 * k), _mm256_permute2f128_ps(rows[k], rows[k + 1], 0x20));
        MLRT_UNROLL
        for (int k = 0; k < 4; k += 2)
            _mm256_storeu_ps((void *)(at + row_stride + 16 * k), _mm256_permute2f128_ps(rows[k], rows[k + 1], 0x31));
    }
}

MLRT_INLINE vd d_of_quad(f4 a) { return _mm256_cvtps_pd(a); }
MLRT_INLINE vd d_load(const float *p) { return _mm256_cvtps_pd(_mm_load_ps(p)); }
MLRT_INLINE void d_store(float *p, vd a) { _mm_store_ps(p, _mm256_cvtpd_ps(a)); }
MLRT_INLINE f4 quad_of_d(vd a) { return _mm256_cvtpd_ps(a); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return _mm256_fmadd_pd(a, b, c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return _mm256_fmsub_pd(a, b, c); }
MLRT_INLINE unsigned d_gt(vd a, vd b) { return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_GT_OQ)); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    return (unsigned)_mm_movemask_ps(_mm_cmpeq_ps(_mm256_cvtpd_ps(a), _mm256_cvtpd_ps(b)));
}

#endif
