/* SPDX-License-Identifier: MIT */
/*
 * Vectors of four floats in plain C, where the width of kernels does not matter: the corners or edges of a triangle and
 * a fourth element, four boxes, bins, or results in a row. It defines each word for the other quad_*.h.
 */
#ifndef MLRT_QUAD_SCALAR_H
#define MLRT_QUAD_SCALAR_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/platform.h"

typedef struct {
    float x[4];
} f4;
MLRT_INLINE f4 f4_set1(float a) { return (f4){{a, a, a, a}}; }
MLRT_INLINE f4 f4_load(const float *p) { return (f4){{p[0], p[1], p[2], p[3]}}; } /* aligned to 16 bytes */
MLRT_INLINE void f4_store(float *p, f4 a) { memcpy(p, a.x, sizeof a.x); }         /* aligned to 16 bytes */
/* the whole parts of the first three lanes, and a fourth of no meaning; aligned to 16 bytes */
MLRT_INLINE void f4_store_whole(int32_t *p, f4 a)
{
    for (int i = 0; i < 3; ++i) p[i] = (int32_t)a.x[i];
}
/* any four words, unchanged, at any address */
MLRT_INLINE f4 f4_load_any(const void *p)
{
    f4 a;
    memcpy(a.x, p, sizeof a.x);
    return a;
}
MLRT_INLINE void f4_store_any(void *p, f4 a) { memcpy(p, a.x, sizeof a.x); }
/* the first two lanes; the last two */
MLRT_INLINE void f4_store_low(void *p, f4 a) { memcpy(p, a.x, 2 * sizeof a.x[0]); }
MLRT_INLINE void f4_store_high(void *p, f4 a) { memcpy(p, a.x + 2, 2 * sizeof a.x[0]); }
/* bits of those of the four words at p that are `word` */
MLRT_INLINE unsigned f4_same_words(const void *p, uint32_t word)
{
    uint32_t words[4];
    memcpy(words, p, sizeof words);
    return (words[0] == word) | (words[1] == word) << 1 | (words[2] == word) << 2 | (words[3] == word) << 3;
}
/* bits of the lanes that are 0 */
MLRT_INLINE unsigned f4_zeros(f4 a)
{
    return (unsigned)((a.x[0] == 0) | (a.x[1] == 0) << 1 | (a.x[2] == 0) << 2 | (a.x[3] == 0) << 3);
}
/* bits of the lanes where a > b */
MLRT_INLINE unsigned f4_above(f4 a, f4 b)
{
    return (unsigned)((a.x[0] > b.x[0]) | (a.x[1] > b.x[1]) << 1 | (a.x[2] > b.x[2]) << 2 | (a.x[3] > b.x[3]) << 3);
}
/* bits of the lanes that are 0 or whose magnitude is lo .. hi */
MLRT_INLINE unsigned f4_zeros_or_within(f4 a, float lo, float hi)
{
    unsigned bits = f4_zeros(a);
    for (int i = 0; i < 4; ++i) bits |= (unsigned)(lo <= fabsf(a.x[i]) && fabsf(a.x[i]) <= hi) << i;
    return bits;
}
/*
 * Are the magnitudes of all lanes of a and b at least lo, and less than hi? lo is a power of 2. If hi is none, the
 * answer may be either for magnitudes whose upper 16 bits are those of hi.
 */
MLRT_INLINE int f4_are_within(f4 a, f4 b, float lo, float hi)
{
    int outside = 0;
    for (int i = 0; i < 4; ++i) {
        outside |= !(lo <= fabsf(a.x[i]) && fabsf(a.x[i]) < hi) | !(lo <= fabsf(b.x[i]) && fabsf(b.x[i]) < hi);
    }
    return !outside;
}
/*
 * p[0], p[1], p[2], p[2], loaded one by one: a vector load of floats that were stored one by one just before would wait
 * until the stores are done.
 */
MLRT_INLINE f4 f4_three(const float *p) { return (f4){{p[0], p[1], p[2], p[2]}}; }
/* lanes 1, 2, 3, 3 of a */
MLRT_INLINE f4 f4_rest(f4 a) { return (f4){{a.x[1], a.x[2], a.x[3], a.x[3]}}; }
/* a, but NaN where the sign bit of `sign` is set */
MLRT_INLINE f4 f4_hide(f4 a, f4 sign)
{
    for (int i = 0; i < 4; ++i) a.x[i] = signbit(sign.x[i]) ? NAN : a.x[i];
    return a;
}
/* bits of the lanes with a sign bit */
MLRT_INLINE unsigned f4_signs(f4 a)
{
    uint32_t words[4];
    memcpy(words, a.x, sizeof words);
    return (words[0] >> 31) | (words[1] >> 31) << 1 | (words[2] >> 31) << 2 | (words[3] >> 31) << 3;
}
MLRT_INLINE f4 f4_add(f4 a, f4 b) { return (f4){{a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2], a.x[3] + b.x[3]}}; }
MLRT_INLINE f4 f4_sub(f4 a, f4 b) { return (f4){{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2], a.x[3] - b.x[3]}}; }
MLRT_INLINE f4 f4_mul(f4 a, f4 b) { return (f4){{a.x[0] * b.x[0], a.x[1] * b.x[1], a.x[2] * b.x[2], a.x[3] * b.x[3]}}; }
MLRT_INLINE f4 f4_div(f4 a, f4 b) { return (f4){{a.x[0] / b.x[0], a.x[1] / b.x[1], a.x[2] / b.x[2], a.x[3] / b.x[3]}}; }
MLRT_INLINE f4 f4_min(f4 a, f4 b)
{
    return (f4){{a.x[0] < b.x[0] ? a.x[0] : b.x[0], a.x[1] < b.x[1] ? a.x[1] : b.x[1],
                 a.x[2] < b.x[2] ? a.x[2] : b.x[2], a.x[3] < b.x[3] ? a.x[3] : b.x[3]}};
}
MLRT_INLINE f4 f4_max(f4 a, f4 b)
{
    return (f4){{a.x[0] > b.x[0] ? a.x[0] : b.x[0], a.x[1] > b.x[1] ? a.x[1] : b.x[1],
                 a.x[2] > b.x[2] ? a.x[2] : b.x[2], a.x[3] > b.x[3] ? a.x[3] : b.x[3]}};
}
MLRT_INLINE f4 f4_abs(f4 a) { return (f4){{fabsf(a.x[0]), fabsf(a.x[1]), fabsf(a.x[2]), fabsf(a.x[3])}}; }
/* a, negated if b is negative */
MLRT_INLINE f4 f4_flip(f4 a, float b) { return b < 0 ? (f4){{-a.x[0], -a.x[1], -a.x[2], -a.x[3]}} : a; }
/* lanes 1, 2, 0, 1 of a */
MLRT_INLINE f4 f4_next(f4 a) { return (f4){{a.x[1], a.x[2], a.x[0], a.x[1]}}; }
/* lanes 0, 1, 2 of a, and 2 of b */
MLRT_INLINE f4 f4_join(f4 a, f4 b) { return (f4){{a.x[0], a.x[1], a.x[2], b.x[2]}}; }
/* the sums of the first three lanes of a, b and c, and the last lane of no meaning */
MLRT_INLINE f4 f4_sums(f4 a, f4 b, f4 c)
{
    const float sum = c.x[0] + c.x[1] + c.x[2];
    return (f4){{a.x[0] + a.x[1] + a.x[2], b.x[0] + b.x[1] + b.x[2], sum, sum}};
}
MLRT_INLINE float f4_last(f4 a) { return a.x[3]; }
/* the greatest, or the least, of b and those of the lanes 0 to 2 of a that are not NaN */
MLRT_INLINE float f4_greatest_of(f4 a, float b)
{
    for (int i = 0; i < 3; ++i) b = a.x[i] > b ? a.x[i] : b;
    return b;
}
MLRT_INLINE float f4_least_of(f4 a, float b)
{
    for (int i = 0; i < 3; ++i) b = a.x[i] < b ? a.x[i] : b;
    return b;
}
MLRT_INLINE float f4_hmin(f4 a)
{
    const float b = a.x[0] < a.x[2] ? a.x[0] : a.x[2], c = a.x[1] < a.x[3] ? a.x[1] : a.x[3];
    return b < c ? b : c;
}
MLRT_INLINE float f4_hmax(f4 a)
{
    const float b = a.x[0] > a.x[2] ? a.x[0] : a.x[2], c = a.x[1] > a.x[3] ? a.x[1] : a.x[3];
    return b > c ? b : c;
}
/* lanes 0, 1 of a and of b */
MLRT_INLINE f4 f4_low(f4 a, f4 b) { return (f4){{a.x[0], a.x[1], b.x[0], b.x[1]}}; }
/* lanes 2, 3 of a and of b */
MLRT_INLINE f4 f4_high(f4 a, f4 b) { return (f4){{a.x[2], a.x[3], b.x[2], b.x[3]}}; }
/* lanes 0, 2 of a and of b */
MLRT_INLINE f4 f4_evens(f4 a, f4 b) { return (f4){{a.x[0], a.x[2], b.x[0], b.x[2]}}; }
/* lanes 1, 3 of a and of b */
MLRT_INLINE f4 f4_odds(f4 a, f4 b) { return (f4){{a.x[1], a.x[3], b.x[1], b.x[3]}}; }
/* three corners a, b, c of three coordinates each: corner[k] has those along axis k, of a, b, c and a */
MLRT_INLINE void f4_corners(const float v[3][3], f4 corner[3])
{
    for (int k = 0; k < 3; ++k) corner[k] = (f4){{v[0][k], v[1][k], v[2][k], v[0][k]}};
}

#endif
