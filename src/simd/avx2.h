/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in AVX2, eight lanes wide. scalar.h says what each word means. */
#ifndef MLRT_SIMD_AVX2_H
#define MLRT_SIMD_AVX2_H

#include <immintrin.h>

#include "simd/quad_sse.h"

#define VW        8
#define ALL_LANES 255u
#define DW        4
typedef __m256 vf;
typedef __m256i vi;
typedef __m256 vm;
typedef __m256d vd;

MLRT_INLINE vf v_set1(float a) { return _mm256_set1_ps(a); }
MLRT_INLINE vf v_load(const float *p) { return _mm256_load_ps(p); }
MLRT_INLINE vf v_load_any(const float *p) { return _mm256_loadu_ps(p); }
MLRT_INLINE void v_store(float *p, vf a) { _mm256_store_ps(p, a); }
MLRT_INLINE vf v_add(vf a, vf b) { return _mm256_add_ps(a, b); }
MLRT_INLINE vf v_sub(vf a, vf b) { return _mm256_sub_ps(a, b); }
MLRT_INLINE vf v_mul(vf a, vf b) { return _mm256_mul_ps(a, b); }
MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return _mm256_fmadd_ps(a, b, c); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return _mm256_fmsub_ps(a, b, c); }
MLRT_INLINE vf v_div(vf a, vf b) { return _mm256_div_ps(a, b); }
MLRT_INLINE vf v_min(vf a, vf b) { return _mm256_min_ps(a, b); }
MLRT_INLINE vf v_max(vf a, vf b) { return _mm256_max_ps(a, b); }
MLRT_INLINE vf v_abs(vf a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
MLRT_INLINE vf v_opposite(vf a) { return _mm256_xor_ps(a, _mm256_set1_ps(-0.0f)); }
MLRT_INLINE vf v_flip(vf a, vf b) { return _mm256_xor_ps(a, _mm256_and_ps(b, _mm256_set1_ps(-0.0f))); }
MLRT_INLINE float v_hmin(vf a) { return f4_hmin(_mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1))); }
MLRT_INLINE float v_hmax(vf a) { return f4_hmax(_mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1))); }
MLRT_INLINE f4 v_hmin4(vf a, vf b, vf c, vf d)
{
    const __m256 ab = _mm256_min_ps(_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
    const __m256 cd = _mm256_min_ps(_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
    const __m256 all = _mm256_min_ps(_mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(1, 0, 1, 0)),
                                     _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2)));
    return _mm_min_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1));
}

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

MLRT_INLINE vi i_set1(uint32_t a) { return _mm256_set1_epi32((int)a); }
MLRT_INLINE vi i_load(const uint32_t *p) { return _mm256_load_si256((const __m256i *)(const void *)p); }
MLRT_INLINE vi i_load_any(const uint32_t *p) { return _mm256_loadu_si256((const void *)p); }
MLRT_INLINE void i_store(uint32_t *p, vi a) { _mm256_store_si256((__m256i *)(void *)p, a); }
MLRT_INLINE vi i_sub(vi a, vi b) { return _mm256_sub_epi32(a, b); }
MLRT_INLINE vi i_and(vi a, vi b) { return _mm256_and_si256(a, b); }
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
MLRT_INLINE __m128 triple_at(const unsigned char *p)
{
    return _mm_maskload_ps((const float *)(const void *)p, _mm_setr_epi32(-1, -1, -1, 0));
}
/* Transposes eight quads of words: by_word[k] has word k of each. */
MLRT_INLINE void transpose_quads(const __m256 r[4], vf by_word[4])
{
    const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpacklo_ps(r[2], r[3]);
    const __m256 c = _mm256_unpackhi_ps(r[0], r[1]), d = _mm256_unpackhi_ps(r[2], r[3]);
    by_word[0] = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 1, 0));
    by_word[1] = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(3, 2, 3, 2));
    by_word[2] = _mm256_shuffle_ps(c, d, _MM_SHUFFLE(1, 0, 1, 0));
    by_word[3] = _mm256_shuffle_ps(c, d, _MM_SHUFFLE(3, 2, 3, 2));
}
MLRT_INLINE void v_triples_at(const unsigned char *p, size_t step, size_t row_step, vf by_axis[3])
{
    __m256 r[4];
    vf by_word[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += i == 2 ? row_step - step : step) {
        r[i] = _mm256_setr_m128(triple_at(p), triple_at(p + 2 * step));
    }
    transpose_quads(r, by_word);
    by_axis[0] = by_word[0], by_axis[1] = by_word[1], by_axis[2] = by_word[2];
}
MLRT_INLINE void v_quads_at(const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    __m256 r[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += i == 2 ? row_step - step : step) {
        r[i] = _mm256_setr_m128(quad_at(p), quad_at(p + 2 * step));
    }
    transpose_quads(r, by_word);
}
MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    const unsigned char *below = p + row_step;
    const __m256 a = _mm256_setr_m128(quad_at(p), quad_at(below));
    const __m256 b = _mm256_setr_m128(quad_at(p + 16), quad_at(below + 16));
    const __m256 c = _mm256_setr_m128(quad_at(p + 32), quad_at(below + 32));
    const __m256 yz = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
    const __m256 xy = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
    by_axis[0] = squares_of_rows(_mm256_shuffle_ps(a, xy, _MM_SHUFFLE(2, 0, 3, 0)));
    by_axis[1] = squares_of_rows(_mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0)));
    by_axis[2] = squares_of_rows(_mm256_shuffle_ps(yz, c, _MM_SHUFFLE(3, 0, 3, 1)));
}
MLRT_INLINE vf v_floats_at(const unsigned char *p, size_t step, size_t row_step)
{
    return _mm256_setr_m128(square_at(p, step, row_step), square_at(p + 2 * step, step, row_step));
}
MLRT_INLINE void v_store_rows(const float *first, size_t distance, unsigned char *at, size_t row_stride)
{
    for (int i = 0; i < 2; ++i, first += 8, at += 2 * row_stride) {
        __m256 rows[4]; /* of each packet, one in each half */
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) rows[k] = squares_of_rows(_mm256_load_ps(first + k * distance));
        MLRT_UNROLL
        for (int k = 0; k < 4; k += 2) {
            _mm256_storeu_ps((void *)(at + 16 * k), _mm256_permute2f128_ps(rows[k], rows[k + 1], 0x20));
        }
        MLRT_UNROLL
        for (int k = 0; k < 4; k += 2) {
            _mm256_storeu_ps((void *)(at + row_stride + 16 * k), _mm256_permute2f128_ps(rows[k], rows[k + 1], 0x31));
        }
    }
}
MLRT_INLINE void i_pairs_at(const unsigned char *p, size_t step, size_t row_step, vi *firsts, vi *seconds)
{
    const unsigned char *below = p + row_step;
    const __m256 upper = _mm256_setr_m128(pairs_at(p, step), pairs_at(p + 2 * step, step));
    const __m256 lower = _mm256_setr_m128(pairs_at(below, step), pairs_at(below + 2 * step, step));
    *firsts = _mm256_castps_si256(_mm256_shuffle_ps(upper, lower, _MM_SHUFFLE(2, 0, 2, 0)));
    *seconds = _mm256_castps_si256(_mm256_shuffle_ps(upper, lower, _MM_SHUFFLE(3, 1, 3, 1)));
}

MLRT_INLINE vd d_set1(double a) { return _mm256_set1_pd(a); }
MLRT_INLINE vd d_load(const float *p) { return _mm256_cvtps_pd(_mm_load_ps(p)); }
MLRT_INLINE void d_store(float *p, vd a) { _mm_store_ps(p, _mm256_cvtpd_ps(a)); }
MLRT_INLINE double d_first(vd a) { return _mm_cvtsd_f64(_mm256_castpd256_pd128(a)); }
MLRT_INLINE vd d_add(vd a, vd b) { return _mm256_add_pd(a, b); }
MLRT_INLINE vd d_sub(vd a, vd b) { return _mm256_sub_pd(a, b); }
MLRT_INLINE vd d_mul(vd a, vd b) { return _mm256_mul_pd(a, b); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return _mm256_fmadd_pd(a, b, c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return _mm256_fmsub_pd(a, b, c); }
MLRT_INLINE vd d_div(vd a, vd b) { return _mm256_div_pd(a, b); }
MLRT_INLINE vd d_abs(vd a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
MLRT_INLINE vd d_max(vd a, vd b) { return _mm256_max_pd(a, b); }
MLRT_INLINE vd d_flip(vd a, vd b) { return _mm256_xor_pd(a, _mm256_and_pd(b, _mm256_set1_pd(-0.0))); }
MLRT_INLINE vd d_select(unsigned lanes, vd a, vd b)
{
    const __m256i bits = _mm256_set_epi64x(8, 4, 2, 1), own = _mm256_and_si256(_mm256_set1_epi64x((int)lanes), bits);
    return _mm256_blendv_pd(b, a, _mm256_castsi256_pd(_mm256_cmpeq_epi64(own, bits)));
}
MLRT_INLINE unsigned d_gt(vd a, vd b) { return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_GT_OQ)); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    return (unsigned)_mm_movemask_ps(_mm_cmpeq_ps(_mm256_cvtpd_ps(a), _mm256_cvtpd_ps(b)));
}

#endif
