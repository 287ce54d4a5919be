/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in SSE2, four lanes wide. scalar.h says what each word means. */
#ifndef MLRT_SIMD_SSE_H
#define MLRT_SIMD_SSE_H

#include <emmintrin.h>

#include "simd/quad_sse.h"

#define VW        4
#define ALL_LANES 15u
#define DW        2
typedef __m128 vf;
typedef __m128i vi;
typedef __m128 vm;
typedef __m128d vd;

MLRT_INLINE vf v_set1(float a) { return _mm_set1_ps(a); }
MLRT_INLINE vf v_load(const float *p) { return _mm_load_ps(p); }
MLRT_INLINE vf v_load_any(const float *p) { return _mm_loadu_ps(p); }
MLRT_INLINE void v_store(float *p, vf a) { _mm_store_ps(p, a); }
MLRT_INLINE vf v_add(vf a, vf b) { return _mm_add_ps(a, b); }
MLRT_INLINE vf v_sub(vf a, vf b) { return _mm_sub_ps(a, b); }
MLRT_INLINE vf v_mul(vf a, vf b) { return _mm_mul_ps(a, b); }
MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return _mm_add_ps(_mm_mul_ps(a, b), c); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return _mm_sub_ps(_mm_mul_ps(a, b), c); }
MLRT_INLINE vf v_div(vf a, vf b) { return _mm_div_ps(a, b); }
MLRT_INLINE vf v_min(vf a, vf b) { return _mm_min_ps(a, b); }
MLRT_INLINE vf v_max(vf a, vf b) { return _mm_max_ps(a, b); }
MLRT_INLINE vf v_abs(vf a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
MLRT_INLINE vf v_opposite(vf a) { return _mm_xor_ps(a, _mm_set1_ps(-0.0f)); }
MLRT_INLINE vf v_flip(vf a, vf b) { return _mm_xor_ps(a, _mm_and_ps(b, _mm_set1_ps(-0.0f))); }
MLRT_INLINE float v_hmin(vf a) { return f4_hmin(a); }
MLRT_INLINE float v_hmax(vf a) { return f4_hmax(a); }
MLRT_INLINE f4 v_hmin4(vf a, vf b, vf c, vf d)
{
    const __m128 ab = _mm_min_ps(_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
    const __m128 cd = _mm_min_ps(_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
    return _mm_min_ps(_mm_movelh_ps(ab, cd), _mm_movehl_ps(cd, ab));
}

MLRT_INLINE vm v_lt(vf a, vf b) { return _mm_cmplt_ps(a, b); }
MLRT_INLINE vm v_le(vf a, vf b) { return _mm_cmple_ps(a, b); }
MLRT_INLINE vm v_gt(vf a, vf b) { return _mm_cmpgt_ps(a, b); }
MLRT_INLINE vm v_ge(vf a, vf b) { return _mm_cmpge_ps(a, b); }
MLRT_INLINE vm v_eq(vf a, vf b) { return _mm_cmpeq_ps(a, b); }
MLRT_INLINE vf v_select(vm m, vf a, vf b) { return _mm_or_ps(_mm_and_ps(m, a), _mm_andnot_ps(m, b)); }

MLRT_INLINE vm m_and(vm a, vm b) { return _mm_and_ps(a, b); }
MLRT_INLINE vm m_or(vm a, vm b) { return _mm_or_ps(a, b); }
MLRT_INLINE vm m_andnot(vm a, vm b) { return _mm_andnot_ps(b, a); }
MLRT_INLINE unsigned m_bits(vm a) { return (unsigned)_mm_movemask_ps(a); }
MLRT_INLINE vm m_from_bits(unsigned bits)
{
    const __m128i lanes = _mm_set_epi32(8, 4, 2, 1);
    return _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((int)bits), lanes), lanes));
}

MLRT_INLINE vi i_set1(uint32_t a) { return _mm_set1_epi32((int)a); }
MLRT_INLINE vi i_load(const uint32_t *p) { return _mm_load_si128((const __m128i *)(const void *)p); }
MLRT_INLINE vi i_load_any(const uint32_t *p) { return _mm_loadu_si128((const void *)p); }
MLRT_INLINE void i_store(uint32_t *p, vi a) { _mm_store_si128((__m128i *)(void *)p, a); }
MLRT_INLINE vi i_sub(vi a, vi b) { return _mm_sub_epi32(a, b); }
MLRT_INLINE vi i_and(vi a, vi b) { return _mm_and_si128(a, b); }
MLRT_INLINE vm i_lt(vi a, vi b)
{
    const __m128i flip = _mm_set1_epi32((int)0x80000000u);
    return _mm_castsi128_ps(_mm_cmplt_epi32(_mm_xor_si128(a, flip), _mm_xor_si128(b, flip)));
}
MLRT_INLINE vm i_eq(vi a, vi b) { return _mm_castsi128_ps(_mm_cmpeq_epi32(a, b)); }
MLRT_INLINE vi i_select(vm m, vi a, vi b)
{
    const __m128i mask = _mm_castps_si128(m);
    return _mm_or_si128(_mm_and_si128(mask, a), _mm_andnot_si128(mask, b));
}

MLRT_INLINE __m128 triple_at(const unsigned char *p)
{
    const float *f = (const float *)(const void *)p;
    return _mm_movelh_ps(_mm_castsi128_ps(_mm_loadl_epi64((const void *)p)), _mm_load_ss(f + 2));
}
MLRT_INLINE void transpose_quads(const __m128 r[4], vf by_word[4])
{
    const __m128 a = _mm_unpacklo_ps(r[0], r[1]), b = _mm_unpacklo_ps(r[2], r[3]);
    const __m128 c = _mm_unpackhi_ps(r[0], r[1]), d = _mm_unpackhi_ps(r[2], r[3]);
    by_word[0] = _mm_movelh_ps(a, b);
    by_word[1] = _mm_movehl_ps(b, a);
    by_word[2] = _mm_movelh_ps(c, d);
    by_word[3] = _mm_movehl_ps(d, c);
}
MLRT_INLINE void v_triples_at(const unsigned char *p, size_t step, size_t row_step, vf by_axis[3])
{
    const unsigned char *below = p + row_step;
    const __m128 r[4] = {triple_at(p), triple_at(p + step), triple_at(below), triple_at(below + step)};
    vf by_word[4];
    transpose_quads(r, by_word);
    by_axis[0] = by_word[0], by_axis[1] = by_word[1], by_axis[2] = by_word[2];
}
MLRT_INLINE void v_quads_at(const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    const unsigned char *below = p + row_step;
    const __m128 r[4] = {quad_at(p), quad_at(p + step), quad_at(below), quad_at(below + step)};
    transpose_quads(r, by_word);
}
MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    v_triples_at(p, 12, row_step, by_axis);
}
MLRT_INLINE vf v_floats_at(const unsigned char *p, size_t step, size_t row_step)
{
    return square_at(p, step, row_step);
}
MLRT_INLINE void v_store_rows(const float *first, size_t distance, unsigned char *at, size_t row_stride)
{
    for (int i = 0; i < 2; ++i, first += 8, at += 2 * row_stride) {
        __m128 upper[4], lower[4];
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) {
            const __m128 left = _mm_load_ps(first + k * distance), right = _mm_load_ps(first + k * distance + 4);
            upper[k] = _mm_movelh_ps(left, right);
            lower[k] = _mm_movehl_ps(right, left);
        }
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) f4_store_any(at + 16 * k, upper[k]);
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) f4_store_any(at + row_stride + 16 * k, lower[k]);
    }
}
MLRT_INLINE void i_pairs_at(const unsigned char *p, size_t step, size_t row_step, vi *firsts, vi *seconds)
{
    const __m128 upper = pairs_at(p, step), lower = pairs_at(p + row_step, step);
    *firsts = _mm_castps_si128(_mm_shuffle_ps(upper, lower, _MM_SHUFFLE(2, 0, 2, 0)));
    *seconds = _mm_castps_si128(_mm_shuffle_ps(upper, lower, _MM_SHUFFLE(3, 1, 3, 1)));
}

MLRT_INLINE vd d_set1(double a) { return _mm_set1_pd(a); }
MLRT_INLINE vd d_load(const float *p) { return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64((const void *)p))); }
MLRT_INLINE void d_store(float *p, vd a) { _mm_storel_pi((void *)p, _mm_cvtpd_ps(a)); }
MLRT_INLINE double d_first(vd a) { return _mm_cvtsd_f64(a); }
MLRT_INLINE vd d_add(vd a, vd b) { return _mm_add_pd(a, b); }
MLRT_INLINE vd d_sub(vd a, vd b) { return _mm_sub_pd(a, b); }
MLRT_INLINE vd d_mul(vd a, vd b) { return _mm_mul_pd(a, b); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return d_add(d_mul(a, b), c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return d_sub(d_mul(a, b), c); }
MLRT_INLINE vd d_div(vd a, vd b) { return _mm_div_pd(a, b); }
MLRT_INLINE vd d_abs(vd a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a); }
MLRT_INLINE vd d_max(vd a, vd b) { return _mm_max_pd(a, b); }
MLRT_INLINE vd d_flip(vd a, vd b) { return _mm_xor_pd(a, _mm_and_pd(b, _mm_set1_pd(-0.0))); }
MLRT_INLINE vd d_select(unsigned lanes, vd a, vd b)
{
    const int first = -(int)(lanes & 1), second = -(int)(lanes >> 1 & 1);
    const vd own = _mm_castsi128_pd(_mm_set_epi32(second, second, first, first));
    return _mm_or_pd(_mm_and_pd(own, a), _mm_andnot_pd(own, b));
}
MLRT_INLINE unsigned d_gt(vd a, vd b) { return (unsigned)_mm_movemask_pd(_mm_cmpgt_pd(a, b)); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    return (unsigned)_mm_movemask_ps(_mm_cmpeq_ps(_mm_cvtpd_ps(a), _mm_cvtpd_ps(b))) & 3;
}

#endif
