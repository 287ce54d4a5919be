/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in SSE2, four lanes wide. scalar.h says what each word means. */
#ifndef MLRT_SIMD_SSE_H
#define MLRT_SIMD_SSE_H

#include <emmintrin.h>

#include "simd/quad_sse.h"

#define VW          4
#define ALL_LANES   15u
#define DW          2
#define WIDE(name)  _mm_##name
#define WHOLE(name) _mm_##name##_si128
typedef __m128 vf;
typedef __m128i vi;
typedef __m128 vm;
typedef __m128d vd;

MLRT_INLINE f4 least_quad(vf a) { return a; }
MLRT_INLINE f4 greatest_quad(vf a) { return a; }
MLRT_INLINE vf at_quarters(quad_load *load, const unsigned char *p, size_t step, size_t row_step)
{
    return load(p, step, row_step);
}
MLRT_INLINE f4 triple_at(const unsigned char *p, size_t step, size_t row_step)
{
    (void)step, (void)row_step;
    const float *f = (const float *)(const void *)p;
    return _mm_movelh_ps(_mm_castsi128_ps(_mm_loadl_epi64((const void *)p)), _mm_load_ss(f + 2));
}

#include "simd/intrinsics.h"

MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return _mm_add_ps(_mm_mul_ps(a, b), c); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return _mm_sub_ps(_mm_mul_ps(a, b), c); }

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

MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    v_triples_at(p, 12, row_step, by_axis);
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

MLRT_INLINE vd d_of_quad(f4 a) { return _mm_cvtps_pd(a); }
MLRT_INLINE vd d_load(const float *p) { return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64((const void *)p))); }
MLRT_INLINE void d_store(float *p, vd a) { _mm_storel_pi((void *)p, _mm_cvtpd_ps(a)); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return d_add(d_mul(a, b), c); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return d_sub(d_mul(a, b), c); }
MLRT_INLINE unsigned d_gt(vd a, vd b) { return (unsigned)_mm_movemask_pd(_mm_cmpgt_pd(a, b)); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    return (unsigned)_mm_movemask_ps(_mm_cmpeq_ps(_mm_cvtpd_ps(a), _mm_cvtpd_ps(b))) & 3;
}

#endif
