/* SPDX-License-Identifier: MIT */
/*
 * The words that sse.h, avx2.h and avx512.h have in common: intrinsics whose names differ in the width alone. scalar.h
 * says what each word means. The header that includes this one has defined
 *
 *   WIDE(name)         an intrinsic of its width: WIDE(add_ps) is _mm_add_ps, _mm256_add_ps or _mm512_add_ps
 *   WHOLE(name)        the same for names that end in the width of integers: WHOLE(load) is _mm_load_si128 and so on
 *   at_quarters        a vector of quads, each of which `load` makes for a square of 2x2 elements
 *   least_quad         of the quads that a vector consists of, the least in each lane; greatest_quad the greatest
 *   triple_at          three words, and a fourth of no meaning
 *
 * and it defines d_of_quad, the first lanes of a quad as doubles, as many as there are, for double_pair.h and
 * double_quad.h; and quad_of_d, which rounds four doubles to floats, where DW is at least 4.
 */
#ifndef MLRT_SIMD_INTRINSICS_H
#define MLRT_SIMD_INTRINSICS_H

#include "simd/quad_sse.h"

MLRT_INLINE vf v_set1(float a) { return WIDE(set1_ps)(a); }
MLRT_INLINE vf v_load(const float *p) { return WIDE(load_ps)(p); }
MLRT_INLINE vf v_load_any(const float *p) { return WIDE(loadu_ps)(p); }
MLRT_INLINE void v_store(float *p, vf a) { WIDE(store_ps)(p, a); }
MLRT_INLINE vf v_add(vf a, vf b) { return WIDE(add_ps)(a, b); }
MLRT_INLINE vf v_sub(vf a, vf b) { return WIDE(sub_ps)(a, b); }
MLRT_INLINE vf v_mul(vf a, vf b) { return WIDE(mul_ps)(a, b); }
MLRT_INLINE vf v_div(vf a, vf b) { return WIDE(div_ps)(a, b); }
MLRT_INLINE vf v_min(vf a, vf b) { return WIDE(min_ps)(a, b); }
MLRT_INLINE vf v_max(vf a, vf b) { return WIDE(max_ps)(a, b); }
MLRT_INLINE vf v_abs(vf a) { return WIDE(andnot_ps)(WIDE(set1_ps)(-0.0f), a); }
MLRT_INLINE vf v_opposite(vf a) { return WIDE(xor_ps)(a, WIDE(set1_ps)(-0.0f)); }
MLRT_INLINE vf v_flip(vf a, vf b) { return WIDE(xor_ps)(a, WIDE(and_ps)(b, WIDE(set1_ps)(-0.0f))); }
MLRT_INLINE float v_hmin(vf a) { return f4_hmin(least_quad(a)); }
MLRT_INLINE float v_hmax(vf a) { return f4_hmax(greatest_quad(a)); }

MLRT_INLINE vi i_set1(uint32_t a) { return WIDE(set1_epi32)((int)a); }
MLRT_INLINE vi i_load(const uint32_t *p) { return WHOLE(load)((const void *)p); }
MLRT_INLINE vi i_load_any(const uint32_t *p) { return WHOLE(loadu)((const void *)p); }
MLRT_INLINE void i_store(uint32_t *p, vi a) { WHOLE(store)((void *)p, a); }
MLRT_INLINE vi i_sub(vi a, vi b) { return WIDE(sub_epi32)(a, b); }
MLRT_INLINE vi i_and(vi a, vi b) { return WHOLE(and)(a, b); }

MLRT_INLINE vd d_set1(double a) { return WIDE(set1_pd)(a); }
MLRT_INLINE vd d_add(vd a, vd b) { return WIDE(add_pd)(a, b); }
MLRT_INLINE vd d_sub(vd a, vd b) { return WIDE(sub_pd)(a, b); }
MLRT_INLINE vd d_mul(vd a, vd b) { return WIDE(mul_pd)(a, b); }
MLRT_INLINE vd d_div(vd a, vd b) { return WIDE(div_pd)(a, b); }
MLRT_INLINE vd d_abs(vd a) { return WIDE(andnot_pd)(WIDE(set1_pd)(-0.0), a); }
MLRT_INLINE vd d_max(vd a, vd b) { return WIDE(max_pd)(a, b); }
MLRT_INLINE vd d_flip(vd a, vd b) { return WIDE(xor_pd)(a, WIDE(and_pd)(b, WIDE(set1_pd)(-0.0))); }

/* Elements 0 and 1 of each quad of a, then of b; elements 2 and 3. */
MLRT_INLINE vf low_pairs(vf a, vf b) { return WIDE(shuffle_ps)(a, b, _MM_SHUFFLE(1, 0, 1, 0)); }
MLRT_INLINE vf high_pairs(vf a, vf b) { return WIDE(shuffle_ps)(a, b, _MM_SHUFFLE(3, 2, 3, 2)); }

MLRT_INLINE f4 v_hmin4(vf a, vf b, vf c, vf d)
{
    const vf ab = v_min(WIDE(unpacklo_ps)(a, b), WIDE(unpackhi_ps)(a, b));
    const vf cd = v_min(WIDE(unpacklo_ps)(c, d), WIDE(unpackhi_ps)(c, d));
    return least_quad(v_min(low_pairs(ab, cd), high_pairs(ab, cd)));
}

/* by_word[k] has word k of each quad that `load` makes. */
MLRT_INLINE void transposed_at(quad_load *load, const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    vf r[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += i == 2 ? row_step - step : step) r[i] = at_quarters(load, p, step, row_step);
    const vf a = WIDE(unpacklo_ps)(r[0], r[1]), b = WIDE(unpacklo_ps)(r[2], r[3]);
    const vf c = WIDE(unpackhi_ps)(r[0], r[1]), d = WIDE(unpackhi_ps)(r[2], r[3]);
    by_word[0] = low_pairs(a, b);
    by_word[1] = high_pairs(a, b);
    by_word[2] = low_pairs(c, d);
    by_word[3] = high_pairs(c, d);
}
MLRT_INLINE void v_quads_at(const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    transposed_at(quad_at, p, step, row_step, by_word);
}
MLRT_INLINE void v_triples_at(const unsigned char *p, size_t step, size_t row_step, vf by_axis[3])
{
    vf by_word[4];
    transposed_at(triple_at, p, step, row_step, by_word);
    by_axis[0] = by_word[0], by_axis[1] = by_word[1], by_axis[2] = by_word[2];
}
MLRT_INLINE vf v_floats_at(const unsigned char *p, size_t step, size_t row_step)
{
    return at_quarters(square_at, p, step, row_step);
}
MLRT_INLINE void i_pairs_at(const unsigned char *p, size_t step, size_t row_step, vi *firsts, vi *seconds)
{
    const vf upper = at_quarters(pairs_at, p, step, row_step);
    const vf lower = at_quarters(pairs_at, p + row_step, step, row_step);
    *firsts = WHOLE(castps)(WIDE(shuffle_ps)(upper, lower, _MM_SHUFFLE(2, 0, 2, 0)));
    *seconds = WHOLE(castps)(WIDE(shuffle_ps)(upper, lower, _MM_SHUFFLE(3, 1, 3, 1)));
}

#endif
