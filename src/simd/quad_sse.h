/* SPDX-License-Identifier: MIT */
/* Four floats in SSE2. quad_scalar.h says what each word means. */
#ifndef MLRT_QUAD_SSE_H
#define MLRT_QUAD_SSE_H

#include <emmintrin.h>
#include <stdint.h>
#include <string.h>

#include "base/platform.h"

typedef __m128 f4;
MLRT_INLINE f4 f4_set1(float a) { return _mm_set1_ps(a); }
MLRT_INLINE f4 f4_load(const float *p) { return _mm_load_ps(p); }
MLRT_INLINE void f4_store(float *p, f4 a) { _mm_store_ps(p, a); }
MLRT_INLINE void f4_store_whole(int32_t *p, f4 a) { _mm_store_si128((void *)p, _mm_cvttps_epi32(a)); }
MLRT_INLINE f4 f4_load_any(const void *p) { return _mm_loadu_ps(p); }
MLRT_INLINE void f4_store_any(void *p, f4 a) { _mm_storeu_ps(p, a); }
MLRT_INLINE void f4_store_low(void *p, f4 a) { _mm_storel_pi(p, a); }
MLRT_INLINE void f4_store_high(void *p, f4 a) { _mm_storeh_pi(p, a); }
MLRT_INLINE unsigned f4_same_words(const void *p, uint32_t word)
{
    const __m128i same = _mm_cmpeq_epi32(_mm_loadu_si128(p), _mm_set1_epi32((int)word));
    return (unsigned)_mm_movemask_ps(_mm_castsi128_ps(same));
}
MLRT_INLINE unsigned f4_zeros(f4 a) { return (unsigned)_mm_movemask_ps(_mm_cmpeq_ps(a, _mm_setzero_ps())); }
MLRT_INLINE unsigned f4_above(f4 a, f4 b) { return (unsigned)_mm_movemask_ps(_mm_cmpgt_ps(a, b)); }
MLRT_INLINE unsigned f4_zeros_or_within(f4 a, float lo, float hi)
{
    const __m128 b = _mm_andnot_ps(_mm_set1_ps(-0.0f), a), zero = _mm_cmpeq_ps(a, _mm_setzero_ps());
    const __m128 within = _mm_and_ps(_mm_cmple_ps(_mm_set1_ps(lo), b), _mm_cmple_ps(b, _mm_set1_ps(hi)));
    return (unsigned)_mm_movemask_ps(_mm_or_ps(zero, within));
}
MLRT_INLINE int f4_are_within(f4 a, f4 b, float lo, float hi)
{
    int32_t least, greatest; /* upper halves, without signs, are in order: from lo to hi, the last sum is below 2^15 */
    memcpy(&least, &lo, sizeof least);
    memcpy(&greatest, &hi, sizeof greatest);
    const __m128i up_a = _mm_srai_epi32(_mm_castps_si128(a), 16), up_b = _mm_srai_epi32(_mm_castps_si128(b), 16);
    const __m128i up = _mm_slli_epi16(_mm_packs_epi32(up_a, up_b), 1);
    const __m128i past_least = _mm_sub_epi16(up, _mm_set1_epi16((int16_t)(least >> 15)));
    const __m128i to_end = _mm_set1_epi16((int16_t)(INT16_MAX + 1 - ((greatest - least) >> 15)));
    return (_mm_movemask_epi8(_mm_adds_epu16(past_least, to_end)) & 0xAAAA) == 0;
}
MLRT_INLINE f4 f4_three(const float *p)
{
    const __m128 x = _mm_load_ss(p), y = _mm_load_ss(p + 1), z = _mm_load_ss(p + 2);
    return _mm_shuffle_ps(_mm_unpacklo_ps(x, y), z, _MM_SHUFFLE(0, 0, 1, 0));
}
MLRT_INLINE f4 f4_rest(f4 a) { return _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 3, 2, 1)); }
MLRT_INLINE unsigned f4_signs(f4 a) { return (unsigned)_mm_movemask_ps(a); }
MLRT_INLINE f4 f4_add(f4 a, f4 b) { return _mm_add_ps(a, b); }
MLRT_INLINE f4 f4_sub(f4 a, f4 b) { return _mm_sub_ps(a, b); }
MLRT_INLINE f4 f4_mul(f4 a, f4 b) { return _mm_mul_ps(a, b); }
MLRT_INLINE f4 f4_div(f4 a, f4 b) { return _mm_div_ps(a, b); }
MLRT_INLINE f4 f4_min(f4 a, f4 b) { return _mm_min_ps(a, b); }
MLRT_INLINE f4 f4_max(f4 a, f4 b) { return _mm_max_ps(a, b); }
MLRT_INLINE f4 f4_abs(f4 a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
MLRT_INLINE f4 f4_flip(f4 a, float b) { return _mm_xor_ps(a, _mm_and_ps(_mm_set1_ps(b), _mm_set1_ps(-0.0f))); }
MLRT_INLINE f4 f4_hide(f4 a, f4 sign)
{
    return _mm_or_ps(a, _mm_castsi128_ps(_mm_srai_epi32(_mm_castps_si128(sign), 31)));
}
MLRT_INLINE f4 f4_next(f4 a) { return _mm_shuffle_ps(a, a, _MM_SHUFFLE(1, 0, 2, 1)); }
MLRT_INLINE f4 f4_join(f4 a, f4 b) { return _mm_shuffle_ps(a, _mm_unpackhi_ps(a, b), _MM_SHUFFLE(1, 0, 1, 0)); }
MLRT_INLINE f4 f4_sums(f4 a, f4 b, f4 c)
{
    const __m128 xy = _mm_unpacklo_ps(a, b), z = _mm_shuffle_ps(_mm_unpackhi_ps(a, b), c, _MM_SHUFFLE(2, 2, 1, 0));
    const __m128 x = _mm_movelh_ps(xy, c), y = _mm_shuffle_ps(xy, c, _MM_SHUFFLE(1, 1, 3, 2));
    return _mm_add_ps(_mm_add_ps(x, y), z);
}
MLRT_INLINE float f4_last(f4 a) { return _mm_cvtss_f32(_mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 3, 3, 3))); }
MLRT_INLINE float f4_second(f4 a) { return _mm_cvtss_f32(_mm_castsi128_ps(_mm_shuffle_epi32(_mm_castps_si128(a), 1))); }
MLRT_INLINE float f4_third(f4 a) { return _mm_cvtss_f32(_mm_castsi128_ps(_mm_shuffle_epi32(_mm_castps_si128(a), 2))); }
MLRT_INLINE float f4_greatest_of(f4 a, float b)
{
    const float x = _mm_cvtss_f32(a), y = f4_second(a), z = f4_third(a);
    b = y > b ? y : b;
    b = z > b ? z : b;
    return x > b ? x : b;
}
MLRT_INLINE float f4_least_of(f4 a, float b)
{
    const float x = _mm_cvtss_f32(a), y = f4_second(a), z = f4_third(a);
    b = y < b ? y : b;
    b = z < b ? z : b;
    return x < b ? x : b;
}
MLRT_INLINE float f4_hmin(f4 a)
{
    a = _mm_min_ps(a, _mm_movehl_ps(a, a));
    return _mm_cvtss_f32(_mm_min_ss(a, _mm_shuffle_ps(a, a, 1)));
}
MLRT_INLINE float f4_hmax(f4 a)
{
    a = _mm_max_ps(a, _mm_movehl_ps(a, a));
    return _mm_cvtss_f32(_mm_max_ss(a, _mm_shuffle_ps(a, a, 1)));
}
MLRT_INLINE f4 f4_low(f4 a, f4 b) { return _mm_movelh_ps(a, b); }
MLRT_INLINE f4 f4_high(f4 a, f4 b) { return _mm_movehl_ps(b, a); }
MLRT_INLINE f4 f4_evens(f4 a, f4 b) { return _mm_shuffle_ps(a, b, _MM_SHUFFLE(2, 0, 2, 0)); }
MLRT_INLINE f4 f4_odds(f4 a, f4 b) { return _mm_shuffle_ps(a, b, _MM_SHUFFLE(3, 1, 3, 1)); }
/* For v_quads_at and its like: four words at p; two words of two elements; one word of two elements in two rows. */
typedef f4 quad_load(const unsigned char *p, size_t step, size_t row_step);
MLRT_INLINE f4 quad_at(const unsigned char *p, size_t step, size_t row_step)
{
    (void)step, (void)row_step;
    return _mm_loadu_ps((const float *)(const void *)p);
}
MLRT_INLINE f4 pairs_at(const unsigned char *p, size_t step, size_t row_step)
{
    (void)row_step;
    const __m128 first = _mm_castsi128_ps(_mm_loadl_epi64((const void *)p));
    return _mm_loadh_pi(first, (const void *)(p + step));
}
MLRT_INLINE f4 square_at(const unsigned char *p, size_t step, size_t row_step)
{
    if (step == sizeof(float)) return pairs_at(p, row_step, step);
    const __m128 upper = _mm_unpacklo_ps(_mm_load_ss((const void *)p), _mm_load_ss((const void *)(p + step)));
    p += row_step;
    return _mm_movelh_ps(upper, _mm_unpacklo_ps(_mm_load_ss((const void *)p), _mm_load_ss((const void *)(p + step))));
}

MLRT_INLINE void f4_corners(const float v[3][3], f4 corner[3])
{
    /* Reads the last corner from one float earlier, so as not to read past it. */
    const f4 a = _mm_loadu_ps(v[0]), b = _mm_loadu_ps(v[1]), bc = _mm_loadu_ps(v[1] + 2);
    const f4 c = _mm_shuffle_ps(bc, bc, _MM_SHUFFLE(3, 3, 2, 1));
    const f4 ab = _mm_unpacklo_ps(a, b), ca = _mm_unpacklo_ps(c, a);
    corner[0] = _mm_movelh_ps(ab, ca);
    corner[1] = _mm_movehl_ps(ca, ab);
    corner[2] = _mm_movelh_ps(_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, a));
}

#endif
