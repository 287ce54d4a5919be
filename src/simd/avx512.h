/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in AVX-512 (F and DQ), sixteen lanes wide. scalar.h says what each word means. */
#ifndef MLRT_SIMD_AVX512_H
#define MLRT_SIMD_AVX512_H

#include <immintrin.h>

#include "simd/quad_sse.h"

#define VW          16
#define ALL_LANES   65535u
#define DW          8
#define WIDE(name)  _mm512_##name
#define WHOLE(name) _mm512_##name##_si512
typedef __m512 vf;
typedef __m512i vi;
typedef __mmask16 vm;
typedef __m512d vd;

MLRT_INLINE __m256 lower_half(vf a) { return _mm512_castps512_ps256(a); }
MLRT_INLINE __m256 upper_half(vf a) { return _mm512_extractf32x8_ps(a, 1); }
MLRT_INLINE f4 lower_quad(__m256 a) { return _mm256_castps256_ps128(a); }
MLRT_INLINE f4 upper_quad(__m256 a) { return _mm256_extractf128_ps(a, 1); }
MLRT_INLINE f4 least_quad(vf a)
{
    const __m256 least = _mm256_min_ps(lower_half(a), upper_half(a));
    return _mm_min_ps(lower_quad(least), upper_quad(least));
}
MLRT_INLINE f4 greatest_quad(vf a)
{
    const __m256 greatest = _mm256_max_ps(lower_half(a), upper_half(a));
    return _mm_max_ps(lower_quad(greatest), upper_quad(greatest));
}
MLRT_INLINE vf at_quarters(quad_load *load, const unsigned char *p, size_t step, size_t row_step)
{
    const unsigned char *below = p + 2 * row_step, *right = p + 2 * step;
    const __m256 upper = _mm256_setr_m128(load(p, step, row_step), load(right, step, row_step));
    const __m256 lower = _mm256_setr_m128(load(below, step, row_step), load(below + 2 * step, step, row_step));
    return _mm512_insertf32x8(_mm512_castps256_ps512(upper), lower, 1);
}
MLRT_INLINE f4 triple_at(const unsigned char *p, size_t step, size_t row_step)
{
    (void)step, (void)row_step;
    return _mm_maskload_ps((const float *)(const void *)p, _mm_setr_epi32(-1, -1, -1, 0));
}

#include "simd/intrinsics.h"

MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return _mm512_fmadd_ps(a, b, c); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return _mm512_fmsub_ps(a, b, c); }

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

MLRT_INLINE vm i_lt(vi a, vi b) { return _mm512_cmplt_epu32_mask(a, b); }
MLRT_INLINE vm i_eq(vi a, vi b) { return _mm512_cmpeq_epi32_mask(a, b); }
MLRT_INLINE vi i_select(vm m, vi a, vi b) { return _mm512_mask_blend_epi32(m, b, a); }

MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    /*
     * Two rows become squares of 2x2 lanes: columns 0, 1 of the first and of the second row, then columns 2, 3. A row
     * is read by two loads that end where it ends: one of 64 bytes waits for the next line even if that is masked out.
     */
    const __m512i xy = _mm512_setr_epi32(0, 3, 16, 19, 6, 9, 22, 25, 1, 4, 17, 20, 7, 10, 23, 26);
    const __m512i z = _mm512_setr_epi32(2, 5, 18, 21, 8, 11, 24, 27, 2, 5, 18, 21, 8, 11, 24, 27);
    __m512 row[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += row_step)
        row[i] = _mm512_insertf32x4(_mm512_castps256_ps512(_mm256_loadu_ps((const void *)p)), f4_load_any(p + 32), 2);
    const __m512 above = _mm512_permutex2var_ps(row[0], xy, row[1]), below = _mm512_permutex2var_ps(row[2], xy, row[3]);
    by_axis[0] = _mm512_shuffle_f32x4(above, below, 0x44);
    by_axis[1] = _mm512_shuffle_f32x4(above, below, 0xEE);
    by_axis[2] = _mm512_shuffle_f32x4(_mm512_permutex2var_ps(row[0], z, row[1]),
                                      _mm512_permutex2var_ps(row[2], z, row[3]), 0x44);
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

MLRT_INLINE vd d_of_quad(f4 a) { return _mm512_cvtps_pd(_mm256_castps128_ps256(a)); }
MLRT_INLINE vd d_load(const float *p) { return _mm512_cvtps_pd(_mm256_load_ps(p)); }
MLRT_INLINE void d_store(float *p, vd a) { _mm256_store_ps(p, _mm512_cvtpd_ps(a)); }
MLRT_INLINE f4 quad_of_d(vd a) { return lower_quad(_mm512_cvtpd_ps(a)); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return _mm512_fmadd_pd(a, b, c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return _mm512_fmsub_pd(a, b, c); }
MLRT_INLINE unsigned d_gt(vd a, vd b) { return _mm512_cmp_pd_mask(a, b, _CMP_GT_OQ); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(_mm512_cvtpd_ps(a), _mm512_cvtpd_ps(b), _CMP_EQ_OQ));
}

#endif
