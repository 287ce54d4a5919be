/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in AVX-512 (F and DQ), sixteen lanes wide. scalar.h says what each word means. */
#ifndef MLRT_SIMD_AVX512_H
#define MLRT_SIMD_AVX512_H

#include <immintrin.h>

#include "simd/quad_sse.h"

#define VW        16
#define ALL_LANES 65535u
#define DW        8
typedef __m512 vf;
typedef __m512i vi;
typedef __mmask16 vm;
typedef __m512d vd;

MLRT_INLINE vf v_set1(float a) { return _mm512_set1_ps(a); }
MLRT_INLINE vf v_load(const float *p) { return _mm512_load_ps(p); }
MLRT_INLINE vf v_load_any(const float *p) { return _mm512_loadu_ps(p); }
MLRT_INLINE void v_store(float *p, vf a) { _mm512_store_ps(p, a); }
MLRT_INLINE vf v_add(vf a, vf b) { return _mm512_add_ps(a, b); }
MLRT_INLINE vf v_sub(vf a, vf b) { return _mm512_sub_ps(a, b); }
MLRT_INLINE vf v_mul(vf a, vf b) { return _mm512_mul_ps(a, b); }
MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return _mm512_fmadd_ps(a, b, c); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return _mm512_fmsub_ps(a, b, c); }
MLRT_INLINE vf v_div(vf a, vf b) { return _mm512_div_ps(a, b); }
MLRT_INLINE vf v_min(vf a, vf b) { return _mm512_min_ps(a, b); }
MLRT_INLINE vf v_max(vf a, vf b) { return _mm512_max_ps(a, b); }
MLRT_INLINE vf v_abs(vf a) { return _mm512_abs_ps(a); }
MLRT_INLINE vf v_opposite(vf a) { return _mm512_xor_ps(a, _mm512_set1_ps(-0.0f)); }
MLRT_INLINE vf v_flip(vf a, vf b) { return _mm512_xor_ps(a, _mm512_and_ps(b, _mm512_set1_ps(-0.0f))); }
MLRT_INLINE __m256 lower_half(vf a) { return _mm512_castps512_ps256(a); }
MLRT_INLINE __m256 upper_half(vf a) { return _mm512_extractf32x8_ps(a, 1); }
MLRT_INLINE f4 lower_quad(__m256 a) { return _mm256_castps256_ps128(a); }
MLRT_INLINE f4 upper_quad(__m256 a) { return _mm256_extractf128_ps(a, 1); }
MLRT_INLINE f4 min_quad(__m256 a) { return _mm_min_ps(lower_quad(a), upper_quad(a)); }
MLRT_INLINE f4 max_quad(__m256 a) { return _mm_max_ps(lower_quad(a), upper_quad(a)); }
MLRT_INLINE float v_hmin(vf a) { return f4_hmin(min_quad(_mm256_min_ps(lower_half(a), upper_half(a)))); }
MLRT_INLINE float v_hmax(vf a) { return f4_hmax(max_quad(_mm256_max_ps(lower_half(a), upper_half(a)))); }
MLRT_INLINE f4 v_hmin4(vf a, vf b, vf c, vf d)
{
    const __m512 ab = _mm512_min_ps(_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
    const __m512 cd = _mm512_min_ps(_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
    const __m512 all = _mm512_min_ps(_mm512_shuffle_ps(ab, cd, _MM_SHUFFLE(1, 0, 1, 0)),
                                     _mm512_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2)));
    return min_quad(_mm256_min_ps(lower_half(all), upper_half(all)));
}

MLRT_INLINE vm v_lt(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
MLRT_INLINE vm v_le(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
MLRT_INLINE vm v_gt(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ); }
MLRT_INLINE vm v_ge(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_GE_OQ); }
MLRT_INLINE vm v_eq(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
MLRT_INLINE vf v_select(vm m, vf a, vf b) { return _mm512_mask_blend_ps(m, b, a); }

MLRT_INLINE vm m_and(vm a, vm b) { return _kand_mask16(a, b); }
MLRT_INLINE vm m_or(vm a, vm b) { return _kor_mask16(a, b); }
MLRT_INLINE vm m_andnot(vm a, vm b) { return _kandn_mask16(b, a); }
MLRT_INLINE unsigned m_bits(vm a) { return a; }
MLRT_INLINE vm m_from_bits(unsigned bits) { return (vm)bits; }

MLRT_INLINE vi i_set1(uint32_t a) { return _mm512_set1_epi32((int)a); }
MLRT_INLINE vi i_load(const uint32_t *p) { return _mm512_load_si512((const void *)p); }
MLRT_INLINE vi i_load_any(const uint32_t *p) { return _mm512_loadu_si512((const void *)p); }
MLRT_INLINE void i_store(uint32_t *p, vi a) { _mm512_store_si512((void *)p, a); }
MLRT_INLINE vi i_sub(vi a, vi b) { return _mm512_sub_epi32(a, b); }
MLRT_INLINE vi i_and(vi a, vi b) { return _mm512_and_si512(a, b); }
MLRT_INLINE vm i_lt(vi a, vi b) { return _mm512_cmplt_epu32_mask(a, b); }
MLRT_INLINE vm i_eq(vi a, vi b) { return _mm512_cmpeq_epi32_mask(a, b); }
MLRT_INLINE vi i_select(vm m, vi a, vi b) { return _mm512_mask_blend_epi32(m, b, a); }

MLRT_INLINE __m128 triple_at(const unsigned char *p)
{
    return _mm_maskload_ps((const float *)(const void *)p, _mm_setr_epi32(-1, -1, -1, 0));
}
/* Transposes sixteen quads of words: by_word[k] has word k of each. */
MLRT_INLINE void transpose_quads(const __m512 r[4], vf by_word[4])
{
    const __m512 a = _mm512_unpacklo_ps(r[0], r[1]), b = _mm512_unpacklo_ps(r[2], r[3]);
    const __m512 c = _mm512_unpackhi_ps(r[0], r[1]), d = _mm512_unpackhi_ps(r[2], r[3]);
    by_word[0] = _mm512_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 1, 0));
    by_word[1] = _mm512_shuffle_ps(a, b, _MM_SHUFFLE(3, 2, 3, 2));
    by_word[2] = _mm512_shuffle_ps(c, d, _MM_SHUFFLE(1, 0, 1, 0));
    by_word[3] = _mm512_shuffle_ps(c, d, _MM_SHUFFLE(3, 2, 3, 2));
}
MLRT_INLINE __m512 join_quads(__m128 a, __m128 b, __m128 c, __m128 d)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_setr_m128(a, b)), _mm256_setr_m128(c, d), 1);
}
MLRT_INLINE void v_triples_at(const unsigned char *p, size_t step, size_t row_step, vf by_axis[3])
{
    __m512 r[4];
    vf by_word[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += i == 2 ? row_step - step : step) {
        const unsigned char *below = p + 2 * row_step;
        r[i] = join_quads(triple_at(p), triple_at(p + 2 * step), triple_at(below), triple_at(below + 2 * step));
    }
    transpose_quads(r, by_word);
    by_axis[0] = by_word[0], by_axis[1] = by_word[1], by_axis[2] = by_word[2];
}
MLRT_INLINE void v_quads_at(const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    __m512 r[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += i == 2 ? row_step - step : step) {
        const unsigned char *below = p + 2 * row_step;
        r[i] = join_quads(quad_at(p), quad_at(p + 2 * step), quad_at(below), quad_at(below + 2 * step));
    }
    transpose_quads(r, by_word);
}
MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    /*
     * Two rows become squares of 2x2 lanes: columns 0, 1 of the first and of the second row, then columns 2, 3. A row is
     * read by two loads that end where it ends: one of 64 bytes waits for the next line even if that is masked out.
     */
    const __m512i xy = _mm512_setr_epi32(0, 3, 16, 19, 6, 9, 22, 25, 1, 4, 17, 20, 7, 10, 23, 26);
    const __m512i z = _mm512_setr_epi32(2, 5, 18, 21, 8, 11, 24, 27, 2, 5, 18, 21, 8, 11, 24, 27);
    __m512 row[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += row_step) {
        row[i] = _mm512_insertf32x4(_mm512_castps256_ps512(_mm256_loadu_ps((const void *)p)), quad_at(p + 32), 2);
    }
    const __m512 above = _mm512_permutex2var_ps(row[0], xy, row[1]), below = _mm512_permutex2var_ps(row[2], xy, row[3]);
    by_axis[0] = _mm512_shuffle_f32x4(above, below, 0x44);
    by_axis[1] = _mm512_shuffle_f32x4(above, below, 0xEE);
    by_axis[2] = _mm512_shuffle_f32x4(_mm512_permutex2var_ps(row[0], z, row[1]),
                                      _mm512_permutex2var_ps(row[2], z, row[3]), 0x44);
}
MLRT_INLINE vf v_floats_at(const unsigned char *p, size_t step, size_t row_step)
{
    const unsigned char *below = p + 2 * row_step;
    return join_quads(square_at(p, step, row_step), square_at(p + 2 * step, step, row_step),
                      square_at(below, step, row_step), square_at(below + 2 * step, step, row_step));
}
MLRT_INLINE void v_store_rows(const float *first, size_t distance, unsigned char *at, size_t row_stride)
{
    const __m512i pairs[2] = {_mm512_setr_epi64(0, 2, 8, 10, 1, 3, 9, 11),
                              _mm512_setr_epi64(4, 6, 12, 14, 5, 7, 13, 15)};
    __m512d packet[4];
    MLRT_UNROLL
    for (int k = 0; k < 4; ++k) packet[k] = _mm512_castps_pd(_mm512_load_ps(first + k * distance));
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i, at += 2 * row_stride) { /* two rows, one in each half */
        const __m512d left = _mm512_permutex2var_pd(packet[0], pairs[i], packet[1]);
        const __m512d right = _mm512_permutex2var_pd(packet[2], pairs[i], packet[3]);
        _mm512_storeu_pd(at, _mm512_shuffle_f64x2(left, right, 0x44));
        _mm512_storeu_pd(at + row_stride, _mm512_shuffle_f64x2(left, right, 0xEE));
    }
}
MLRT_INLINE void i_pairs_at(const unsigned char *p, size_t step, size_t row_step, vi *firsts, vi *seconds)
{
    const unsigned char *below = p + 2 * row_step;
    const __m512 upper = join_quads(pairs_at(p, step), pairs_at(p + 2 * step, step), pairs_at(below, step),
                                    pairs_at(below + 2 * step, step));
    p += row_step, below += row_step;
    const __m512 lower = join_quads(pairs_at(p, step), pairs_at(p + 2 * step, step), pairs_at(below, step),
                                    pairs_at(below + 2 * step, step));
    *firsts = _mm512_castps_si512(_mm512_shuffle_ps(upper, lower, _MM_SHUFFLE(2, 0, 2, 0)));
    *seconds = _mm512_castps_si512(_mm512_shuffle_ps(upper, lower, _MM_SHUFFLE(3, 1, 3, 1)));
}

MLRT_INLINE vd d_set1(double a) { return _mm512_set1_pd(a); }
MLRT_INLINE vd d_load(const float *p) { return _mm512_cvtps_pd(_mm256_load_ps(p)); }
MLRT_INLINE void d_store(float *p, vd a) { _mm256_store_ps(p, _mm512_cvtpd_ps(a)); }
MLRT_INLINE double d_first(vd a) { return _mm_cvtsd_f64(_mm512_castpd512_pd128(a)); }
MLRT_INLINE vd d_add(vd a, vd b) { return _mm512_add_pd(a, b); }
MLRT_INLINE vd d_sub(vd a, vd b) { return _mm512_sub_pd(a, b); }
MLRT_INLINE vd d_mul(vd a, vd b) { return _mm512_mul_pd(a, b); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return _mm512_fmadd_pd(a, b, c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return _mm512_fmsub_pd(a, b, c); }
MLRT_INLINE vd d_div(vd a, vd b) { return _mm512_div_pd(a, b); }
MLRT_INLINE vd d_abs(vd a) { return _mm512_abs_pd(a); }
MLRT_INLINE vd d_max(vd a, vd b) { return _mm512_max_pd(a, b); }
MLRT_INLINE vd d_flip(vd a, vd b) { return _mm512_xor_pd(a, _mm512_and_pd(b, _mm512_set1_pd(-0.0))); }
MLRT_INLINE vd d_select(unsigned lanes, vd a, vd b) { return _mm512_mask_blend_pd((__mmask8)lanes, b, a); }
MLRT_INLINE unsigned d_gt(vd a, vd b) { return _mm512_cmp_pd_mask(a, b, _CMP_GT_OQ); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(_mm512_cvtpd_ps(a), _mm512_cvtpd_ps(b), _CMP_EQ_OQ));
}

#endif
