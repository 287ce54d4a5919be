/* SPDX-License-Identifier: MIT */
/* Four floats in NEON. quad_scalar.h says what each word means. */
#ifndef MLRT_QUAD_NEON_H
#define MLRT_QUAD_NEON_H

#include "base/platform.h"

#if MLRT_NEON_KERNELS
#include <arm_neon.h>
#include <stdint.h>

typedef float32x4_t f4;

/* The bits of a mask's lanes, each of which is all ones or all zeros. */
MLRT_INLINE unsigned bits_of_lanes(uint32x4_t mask)
{
    static const uint32_t bits[4] = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(mask, vld1q_u32(bits)));
}
MLRT_INLINE uint32x4_t f4_words(f4 a) { return vreinterpretq_u32_f32(a); }
MLRT_INLINE f4 f4_of_words(uint32x4_t a) { return vreinterpretq_f32_u32(a); }

MLRT_INLINE f4 f4_set1(float a) { return vdupq_n_f32(a); }
MLRT_INLINE f4 f4_load(const float *p) { return vld1q_f32(p); }
MLRT_INLINE void f4_store(float *p, f4 a) { vst1q_f32(p, a); }
MLRT_INLINE void f4_store_whole(int32_t *p, f4 a) { vst1q_s32(p, vcvtq_s32_f32(a)); }
MLRT_INLINE f4 f4_load_any(const void *p) { return vreinterpretq_f32_u8(vld1q_u8(p)); }
MLRT_INLINE void f4_store_any(void *p, f4 a) { vst1q_u8(p, vreinterpretq_u8_f32(a)); }
MLRT_INLINE void f4_store_low(void *p, f4 a) { vst1_u8(p, vget_low_u8(vreinterpretq_u8_f32(a))); }
MLRT_INLINE void f4_store_high(void *p, f4 a) { vst1_u8(p, vget_high_u8(vreinterpretq_u8_f32(a))); }
MLRT_INLINE unsigned f4_same_words(const void *p, uint32_t word)
{
    return bits_of_lanes(vceqq_u32(f4_words(f4_load_any(p)), vdupq_n_u32(word)));
}
MLRT_INLINE unsigned f4_zeros(f4 a) { return bits_of_lanes(vceqzq_f32(a)); }
MLRT_INLINE unsigned f4_above(f4 a, f4 b) { return bits_of_lanes(vcgtq_f32(a, b)); }
MLRT_INLINE unsigned f4_zeros_or_within(f4 a, float lo, float hi)
{
    const f4 size = vabsq_f32(a);
    const uint32x4_t within = vandq_u32(vcleq_f32(vdupq_n_f32(lo), size), vcleq_f32(size, vdupq_n_f32(hi)));
    return bits_of_lanes(vorrq_u32(vceqzq_f32(a), within));
}
MLRT_INLINE int f4_are_within(f4 a, f4 b, float lo, float hi)
{
    const f4 x = vabsq_f32(a), y = vabsq_f32(b), from = vdupq_n_f32(lo), to = vdupq_n_f32(hi);
    const uint32x4_t first = vandq_u32(vcleq_f32(from, x), vcltq_f32(x, to));
    const uint32x4_t second = vandq_u32(vcleq_f32(from, y), vcltq_f32(y, to));
    return vminvq_u32(vandq_u32(first, second)) != 0;
}
MLRT_INLINE f4 f4_three(const float *p) { return vld1q_lane_f32(p + 1, vld1q_lane_f32(p, vld1q_dup_f32(p + 2), 0), 1); }
MLRT_INLINE f4 f4_rest(f4 a) { return vextq_f32(a, vdupq_laneq_f32(a, 3), 1); }
MLRT_INLINE unsigned f4_signs(f4 a) { return bits_of_lanes(vcltzq_s32(vreinterpretq_s32_f32(a))); }
MLRT_INLINE f4 f4_add(f4 a, f4 b) { return vaddq_f32(a, b); }
MLRT_INLINE f4 f4_sub(f4 a, f4 b) { return vsubq_f32(a, b); }
MLRT_INLINE f4 f4_mul(f4 a, f4 b) { return vmulq_f32(a, b); }
MLRT_INLINE f4 f4_div(f4 a, f4 b) { return vdivq_f32(a, b); }
/* The instructions for these treat NaN otherwise. */
MLRT_INLINE f4 f4_min(f4 a, f4 b) { return vbslq_f32(vcltq_f32(a, b), a, b); }
MLRT_INLINE f4 f4_max(f4 a, f4 b) { return vbslq_f32(vcgtq_f32(a, b), a, b); }
MLRT_INLINE f4 f4_abs(f4 a) { return vabsq_f32(a); }
/* Each lane of a with its sign flipped where that of b is negative. */
MLRT_INLINE f4 flip_lanes(f4 a, f4 b)
{
    return f4_of_words(veorq_u32(f4_words(a), vandq_u32(f4_words(b), vdupq_n_u32(0x80000000u))));
}
MLRT_INLINE f4 f4_flip(f4 a, float b) { return flip_lanes(a, vdupq_n_f32(b)); }
MLRT_INLINE f4 f4_hide(f4 a, f4 sign)
{
    return f4_of_words(vorrq_u32(f4_words(a), vcltzq_s32(vreinterpretq_s32_f32(sign))));
}
MLRT_INLINE f4 f4_low(f4 a, f4 b) { return vcombine_f32(vget_low_f32(a), vget_low_f32(b)); }
MLRT_INLINE f4 f4_high(f4 a, f4 b) { return vcombine_f32(vget_high_f32(a), vget_high_f32(b)); }
MLRT_INLINE f4 f4_evens(f4 a, f4 b) { return vuzp1q_f32(a, b); }
MLRT_INLINE f4 f4_odds(f4 a, f4 b) { return vuzp2q_f32(a, b); }
MLRT_INLINE f4 f4_next(f4 a) { return f4_low(vextq_f32(a, a, 1), a); }
MLRT_INLINE f4 f4_join(f4 a, f4 b) { return vcopyq_laneq_f32(a, 3, b, 2); }
MLRT_INLINE f4 f4_sums(f4 a, f4 b, f4 c)
{
    const f4 xy = vzip1q_f32(a, b), z = vzip2q_f32(a, b);
    const f4 first = f4_low(xy, c), second = vcombine_f32(vget_high_f32(xy), vget_low_f32(vextq_f32(c, c, 1)));
    return vaddq_f32(vaddq_f32(first, second), vcombine_f32(vget_low_f32(z), vget_high_f32(c)));
}
MLRT_INLINE float f4_last(f4 a) { return vgetq_lane_f32(a, 3); }
MLRT_INLINE float f4_greatest_of(f4 a, float b)
{
    const float x = vgetq_lane_f32(a, 0), y = vgetq_lane_f32(a, 1), z = vgetq_lane_f32(a, 2);
    b = x > b ? x : b;
    b = y > b ? y : b;
    return z > b ? z : b;
}
MLRT_INLINE float f4_least_of(f4 a, float b)
{
    const float x = vgetq_lane_f32(a, 0), y = vgetq_lane_f32(a, 1), z = vgetq_lane_f32(a, 2);
    b = x < b ? x : b;
    b = y < b ? y : b;
    return z < b ? z : b;
}
MLRT_INLINE float f4_hmin(f4 a)
{
    const f4 pairs = f4_min(a, vextq_f32(a, a, 2));
    const float first = vgetq_lane_f32(pairs, 0), second = vgetq_lane_f32(pairs, 1);
    return first < second ? first : second;
}
MLRT_INLINE float f4_hmax(f4 a)
{
    const f4 pairs = f4_max(a, vextq_f32(a, a, 2));
    const float first = vgetq_lane_f32(pairs, 0), second = vgetq_lane_f32(pairs, 1);
    return first > second ? first : second;
}

MLRT_INLINE void f4_corners(const float v[3][3], f4 corner[3])
{
    /* Reads the last corner from one float earlier, so as not to read past it. */
    const f4 a = vld1q_f32(v[0]), b = vld1q_f32(v[1]), c = f4_rest(vld1q_f32(v[1] + 2));
    const f4 ab = vzip1q_f32(a, b), ca = vzip1q_f32(c, a);
    corner[0] = f4_low(ab, ca);
    corner[1] = f4_high(ab, ca);
    corner[2] = f4_low(vzip2q_f32(a, b), vzip2q_f32(c, a));
}

#endif

#endif
