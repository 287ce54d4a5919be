/* SPDX-License-Identifier: MIT */
/* The vocabulary of the kernels in NEON, four lanes wide, for aarch64. scalar.h says what each word means. */
#ifndef MLRT_SIMD_NEON_H
#define MLRT_SIMD_NEON_H

#include <stddef.h>

#include "simd/quad_neon.h"

#if MLRT_NEON_KERNELS

#define VW        4
#define ALL_LANES 15u
#define DW        2
typedef float32x4_t vf;
typedef uint32x4_t vi;
typedef uint32x4_t vm;
typedef float64x2_t vd;

MLRT_INLINE vf v_set1(float a) { return vdupq_n_f32(a); }
MLRT_INLINE vf v_load(const float *p) { return vld1q_f32(p); }
MLRT_INLINE vf v_load_any(const float *p) { return vld1q_f32(p); }
MLRT_INLINE void v_store(float *p, vf a) { vst1q_f32(p, a); }
MLRT_INLINE vf v_add(vf a, vf b) { return vaddq_f32(a, b); }
MLRT_INLINE vf v_sub(vf a, vf b) { return vsubq_f32(a, b); }
MLRT_INLINE vf v_mul(vf a, vf b) { return vmulq_f32(a, b); }
MLRT_INLINE vf v_mul_add(vf a, vf b, vf c) { return vfmaq_f32(c, a, b); }
MLRT_INLINE vf v_mul_sub(vf a, vf b, vf c) { return vfmaq_f32(vnegq_f32(c), a, b); }
MLRT_INLINE vf v_div(vf a, vf b) { return vdivq_f32(a, b); }
MLRT_INLINE vf v_min(vf a, vf b) { return f4_min(a, b); }
MLRT_INLINE vf v_max(vf a, vf b) { return f4_max(a, b); }
MLRT_INLINE vf v_abs(vf a) { return vabsq_f32(a); }
MLRT_INLINE vf v_opposite(vf a) { return vnegq_f32(a); }
MLRT_INLINE vf v_flip(vf a, vf b) { return flip_lanes(a, b); }
MLRT_INLINE float v_hmin(vf a) { return f4_hmin(a); }
MLRT_INLINE float v_hmax(vf a) { return f4_hmax(a); }

MLRT_INLINE vm v_lt(vf a, vf b) { return vcltq_f32(a, b); }
MLRT_INLINE vm v_le(vf a, vf b) { return vcleq_f32(a, b); }
MLRT_INLINE vm v_gt(vf a, vf b) { return vcgtq_f32(a, b); }
MLRT_INLINE vm v_ge(vf a, vf b) { return vcgeq_f32(a, b); }
MLRT_INLINE vm v_eq(vf a, vf b) { return vceqq_f32(a, b); }
MLRT_INLINE vf v_select(vm m, vf a, vf b) { return vbslq_f32(m, a, b); }

MLRT_INLINE vm m_and(vm a, vm b) { return vandq_u32(a, b); }
MLRT_INLINE vm m_or(vm a, vm b) { return vorrq_u32(a, b); }
MLRT_INLINE vm m_andnot(vm a, vm b) { return vbicq_u32(a, b); }
MLRT_INLINE unsigned m_bits(vm a) { return bits_of_lanes(a); }
MLRT_INLINE vm m_from_bits(unsigned bits)
{
    static const uint32_t lanes[4] = {1, 2, 4, 8};
    return vtstq_u32(vdupq_n_u32(bits), vld1q_u32(lanes));
}

MLRT_INLINE vi i_set1(uint32_t a) { return vdupq_n_u32(a); }
MLRT_INLINE vi i_load(const uint32_t *p) { return vld1q_u32(p); }
MLRT_INLINE vi i_load_any(const uint32_t *p) { return vld1q_u32(p); }
MLRT_INLINE void i_store(uint32_t *p, vi a) { vst1q_u32(p, a); }
MLRT_INLINE vi i_sub(vi a, vi b) { return vsubq_u32(a, b); }
MLRT_INLINE vi i_and(vi a, vi b) { return vandq_u32(a, b); }
MLRT_INLINE vm i_lt(vi a, vi b) { return vcltq_u32(a, b); }
MLRT_INLINE vm i_eq(vi a, vi b) { return vceqq_u32(a, b); }
MLRT_INLINE vi i_select(vm m, vi a, vi b) { return vbslq_u32(m, a, b); }

MLRT_INLINE f4 v_hmin4(vf a, vf b, vf c, vf d)
{
    const vf ab = v_min(vzip1q_f32(a, b), vzip2q_f32(a, b)), cd = v_min(vzip1q_f32(c, d), vzip2q_f32(c, d));
    return v_min(f4_low(ab, cd), f4_high(ab, cd));
}

/* by_word[k] has word k of each row. */
MLRT_INLINE void transpose(const vf row[4], vf by_word[4])
{
    const vf a = vzip1q_f32(row[0], row[1]), b = vzip1q_f32(row[2], row[3]);
    const vf c = vzip2q_f32(row[0], row[1]), d = vzip2q_f32(row[2], row[3]);
    by_word[0] = f4_low(a, b);
    by_word[1] = f4_high(a, b);
    by_word[2] = f4_low(c, d);
    by_word[3] = f4_high(c, d);
}
MLRT_INLINE vf pair_at(const unsigned char *p, size_t step)
{
    return vcombine_f32(vreinterpret_f32_u8(vld1_u8(p)), vreinterpret_f32_u8(vld1_u8(p + step)));
}
MLRT_INLINE void v_quads_at(const unsigned char *p, size_t step, size_t row_step, vf by_word[4])
{
    const vf row[4] = {f4_load_any(p), f4_load_any(p + step), f4_load_any(p + row_step),
                       f4_load_any(p + row_step + step)};
    transpose(row, by_word);
}
MLRT_INLINE void v_triples_at(const unsigned char *p, size_t step, size_t row_step, vf by_axis[3])
{
    vf row[4], by_word[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i, p += i == 2 ? row_step - step : step) {
        const float32x2_t third = vld1_dup_f32((const void *)(p + 8));
        row[i] = vcombine_f32(vreinterpret_f32_u8(vld1_u8(p)), third);
    }
    transpose(row, by_word);
    by_axis[0] = by_word[0], by_axis[1] = by_word[1], by_axis[2] = by_word[2];
}
MLRT_INLINE void v_triples(const unsigned char *p, size_t row_step, vf by_axis[3])
{
    v_triples_at(p, 12, row_step, by_axis);
}
MLRT_INLINE vf v_floats_at(const unsigned char *p, size_t step, size_t row_step)
{
    if (step == sizeof(float)) return pair_at(p, row_step);
    vf a = vld1q_dup_f32((const void *)p);
    a = vld1q_lane_f32((const void *)(p + step), a, 1);
    a = vld1q_lane_f32((const void *)(p + row_step), a, 2);
    return vld1q_lane_f32((const void *)(p + row_step + step), a, 3);
}
MLRT_INLINE void i_pairs_at(const unsigned char *p, size_t step, size_t row_step, vi *firsts, vi *seconds)
{
    const vf upper = pair_at(p, step), lower = pair_at(p + row_step, step);
    *firsts = f4_words(f4_evens(upper, lower));
    *seconds = f4_words(f4_odds(upper, lower));
}
MLRT_INLINE void v_store_rows(const float *first, size_t distance, unsigned char *at, size_t row_stride)
{
    for (int i = 0; i < 2; ++i, first += 8, at += 2 * row_stride) {
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) {
            const vf left = vld1q_f32(first + k * distance), right = vld1q_f32(first + k * distance + 4);
            f4_store_any(at + 16 * k, f4_low(left, right));
            f4_store_any(at + row_stride + 16 * k, f4_high(left, right));
        }
    }
}

MLRT_INLINE uint64x2_t d_words(vd a) { return vreinterpretq_u64_f64(a); }
MLRT_INLINE unsigned bits_of_doubles(uint64x2_t mask)
{
    return (unsigned)((vgetq_lane_u64(mask, 0) & 1) | (vgetq_lane_u64(mask, 1) & 2));
}
MLRT_INLINE vd d_set1(double a) { return vdupq_n_f64(a); }
MLRT_INLINE vd d_load(const float *p) { return vcvt_f64_f32(vld1_f32(p)); }
MLRT_INLINE void d_store(float *p, vd a) { vst1_f32(p, vcvt_f32_f64(a)); }
MLRT_INLINE vd d_add(vd a, vd b) { return vaddq_f64(a, b); }
MLRT_INLINE vd d_sub(vd a, vd b) { return vsubq_f64(a, b); }
MLRT_INLINE vd d_mul(vd a, vd b) { return vmulq_f64(a, b); }
MLRT_INLINE vd d_mul_add(vd a, vd b, vd c) { return vfmaq_f64(c, a, b); }
MLRT_INLINE vd d_mul_sub(vd a, vd b, vd c) { return vfmaq_f64(vnegq_f64(c), a, b); }
MLRT_INLINE vd d_div(vd a, vd b) { return vdivq_f64(a, b); }
MLRT_INLINE vd d_abs(vd a) { return vabsq_f64(a); }
MLRT_INLINE vd d_max(vd a, vd b) { return vbslq_f64(vcgtq_f64(a, b), a, b); }
MLRT_INLINE vd d_flip(vd a, vd b)
{
    const uint64x2_t sign = vandq_u64(d_words(b), d_words(vdupq_n_f64(-0.0)));
    return vreinterpretq_f64_u64(veorq_u64(d_words(a), sign));
}
MLRT_INLINE unsigned d_gt(vd a, vd b) { return bits_of_doubles(vcgtq_f64(a, b)); }
MLRT_INLINE unsigned d_same_float(vd a, vd b)
{
    const uint32x2_t same = vceq_f32(vcvt_f32_f64(a), vcvt_f32_f64(b));
    return (vget_lane_u32(same, 0) & 1) | (vget_lane_u32(same, 1) & 2);
}

#endif

#endif
