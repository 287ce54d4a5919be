/* SPDX-License-Identifier: MIT */
/*
 * run_words in the vocabulary that was included before, under the name RUN_WORDS.
 */
#include <math.h>
#include <string.h>

#include "rays/packet.h"
#include "simd/double_pair.h"
#include "simd/double_quad.h"
#include "words.h"

static void put_mask(struct word_output *out, int word, int v, vm mask)
{
    /* Above the lanes there must be nothing. */
    const uint32_t bits = m_bits(mask), past = bits & ~ALL_LANES;
    for (int i = 0; i < VW; ++i) out->integers[word][v + i] = (bits >> i & 1) | past;
}

static void run_vector(const struct word_input *in, int v, struct word_output *out)
{
    const vf a = v_load(in->a + v), b = v_load(in->b + v);
    const vi whole_a = i_load(in->bits_a + v), whole_b = i_load(in->bits_b + v);
    const vm some = m_from_bits(in->lanes >> v), less = v_lt(a, b);
    v_store(out->values[WORD_SET1] + v, v_set1(in->a[0]));
    v_store(out->values[WORD_ADD] + v, v_add(a, b));
    v_store(out->values[WORD_SUB] + v, v_sub(a, b));
    v_store(out->values[WORD_MUL] + v, v_mul(a, b));
    v_store(out->values[WORD_DIV] + v, v_div(a, b));
    v_store(out->values[WORD_MUL_ADD] + v, v_add(v_mul(a, b), a));
    v_store(out->values[WORD_AT_ONCE_ADD] + v, v_mul_add(a, b, a));
    v_store(out->values[WORD_AT_ONCE_SUB] + v, v_mul_sub(a, b, a));
    v_store(out->values[WORD_MIN] + v, v_min(a, b));
    v_store(out->values[WORD_MAX] + v, v_max(a, b));
    v_store(out->values[WORD_ABS] + v, v_abs(a));
    v_store(out->values[WORD_FLIP] + v, v_opposite(v_flip(a, b)));
    v_store(out->values[WORD_SELECT] + v, v_select(some, a, b));
    i_store(out->integers[WORD_INTEGER_SET1] + v, i_set1(in->lanes));
    i_store(out->integers[WORD_INTEGER_SELECT] + v, i_select(less, whole_a, whole_b));
    i_store(out->integers[WORD_INTEGER_SUB] + v, i_sub(whole_a, i_and(whole_a, whole_b)));
    put_mask(out, WORD_INTEGER_LT, v, i_lt(whole_a, whole_b));
    put_mask(out, WORD_LT, v, less);
    put_mask(out, WORD_LE, v, v_le(a, b));
    put_mask(out, WORD_GT, v, v_gt(a, b));
    put_mask(out, WORD_GE, v, v_ge(a, b));
    put_mask(out, WORD_EQ, v, v_eq(a, b));
    put_mask(out, WORD_INTEGER_EQ, v, i_eq(whole_a, whole_b));
    put_mask(out, WORD_FROM_BITS, v, some);
    put_mask(out, WORD_AND, v, m_and(some, less));
    put_mask(out, WORD_OR, v, m_or(some, less));
    put_mask(out, WORD_AND_NOT, v, m_andnot(some, less));
}

/* From addresses that are a multiple of four, and of no more. */
static void run_loads(const struct word_input *in, int v, struct word_output *out)
{
    MLRT_ALIGNED(64) float values[WORD_LANES + 1];
    MLRT_ALIGNED(64) uint32_t integers[WORD_LANES + 1];
    memcpy(values + 1, in->a, sizeof in->a);
    memcpy(integers + 1, in->bits_a, sizeof in->bits_a);
    v_store(out->values[WORD_LOAD_ANY] + v, v_load_any(values + 1 + v));
    i_store(out->integers[WORD_INTEGER_LOAD_ANY] + v, i_load_any(integers + 1 + v));
}

/* Four rows of four elements, of which the last ends the array: of three, four, one and two words. */
static void run_blocks(const struct word_input *in, struct word_output *out)
{
    enum { STEP = 5, ROW = 21, WORDS = 3 * ROW + 3 * STEP };
    float words[WORDS + 4];
    for (int i = 0; i < WORDS + 4; ++i) words[i] = i % 3 == 1 ? in->b[i % 16] : in->a[i % 16] + (float)(i / 16);
    for (int v = 0; v < WORD_LANES; v += VW) {
        const int x = (int)mlrt_lane_x[v], y = (int)mlrt_lane_y[v];
        const unsigned char *first = (const unsigned char *)(words + y * ROW);
        vf by_word[4];
        vi seconds, firsts;
        v_triples(first + 12 * x, 4 * ROW, by_word);
        for (int k = 0; k < 3; ++k) v_store(out->values[WORD_TRIPLES + k] + v, by_word[k]);
        v_triples_at(first + 4 * STEP * x + 4, 4 * STEP, 4 * ROW, by_word);
        for (int k = 0; k < 3; ++k) v_store(out->values[WORD_TRIPLES_AT + k] + v, by_word[k]);
        v_quads_at(first + 4 * STEP * x, 4 * STEP, 4 * ROW, by_word);
        for (int k = 0; k < 4; ++k) v_store(out->values[WORD_QUADS_AT + k] + v, by_word[k]);
        v_store(out->values[WORD_FLOATS_AT] + v, v_floats_at(first + 4 * x, 4, 4 * ROW));
        v_store(out->values[WORD_FLOATS_AT + 1] + v, v_floats_at(first + 4 * STEP * x + 12, 4 * STEP, 4 * ROW));
        i_pairs_at(first + 4 * STEP * x + 8, 4 * STEP, 4 * ROW, &firsts, &seconds);
        i_store(out->integers[WORD_PAIRS_AT] + v, firsts);
        i_store(out->integers[WORD_PAIRS_AT + 1] + v, seconds);
    }
}

/* Four packets, the third and the fourth of which have the lanes of the others in another order. */
static void run_rows(const struct word_input *in, struct word_output *out)
{
    MLRT_ALIGNED(64) float packets[4][2 * WORD_LANES];
    for (int i = 0; i < WORD_LANES; ++i) {
        packets[0][i] = in->a[i], packets[2][i] = in->a[(i + 5) % WORD_LANES];
        packets[1][i] = in->b[i], packets[3][i] = in->b[(i + 3) % WORD_LANES];
    }
    v_store_rows(packets[0], 2 * WORD_LANES, (unsigned char *)out->values[WORD_STORE_ROWS], sizeof out->values[0]);
}

static void put_bits(struct word_output *out, int word, int lane, unsigned bits)
{
    const unsigned past = bits >> DW;
    for (int i = 0; i < DW; ++i) out->integers[word][lane + i] = (bits >> i & 1) | past;
}

/* Quotients a / b and their neighbours in double are looked at beside the floats: there is more to be rounded. */
static void run_doubles(const struct word_input *in, int lane, struct word_output *out)
{
    const vd a = d_load(in->a + lane), b = d_load(in->b + lane), quotient = d_div(a, b);
    const vd near = d_mul(quotient, d_set1(1 + 0x1p-24)), nearer = d_mul(quotient, d_set1(1 + 0x1p-25));
    d_store(out->values[WORD_DOUBLE_SET1] + lane, d_set1((double)in->a[0] + 0x1p-30));
    d_store(out->values[WORD_DOUBLE_LOAD] + lane, a);
    d_store(out->values[WORD_DOUBLE_ADD] + lane, d_add(quotient, b));
    d_store(out->values[WORD_DOUBLE_SUB] + lane, d_sub(quotient, b));
    d_store(out->values[WORD_DOUBLE_MUL] + lane, nearer);
    d_store(out->values[WORD_DOUBLE_DIV] + lane, quotient);
    d_store(out->values[WORD_DOUBLE_MUL_ADD] + lane, d_sub(d_mul(quotient, b), a));
    d_store(out->values[WORD_DOUBLE_ABS] + lane, d_abs(quotient));
    d_store(out->values[WORD_DOUBLE_MAX] + lane, d_max(a, b));
    d_store(out->values[WORD_DOUBLE_FLIP] + lane, d_flip(a, b));
    put_bits(out, WORD_DOUBLE_GT, lane, d_gt(a, b) ^ d_gt(near, quotient));
    put_bits(out, WORD_DOUBLE_SAME_FLOAT, lane, d_same_float(quotient, nearer));
}

static void put_pair(struct word_output *out, int word, int lane, d2 pair)
{
    out->values[word][lane] = (float)d2_first(pair);
    out->values[word + 1][lane] = (float)d2_first(d2_swap(pair));
}

static void run_pair(const struct word_input *in, int lane, struct word_output *out)
{
    const float *p = in->a + lane, *q = in->b + lane;
    const d2 a = d2_load(p, q), b = d2_mul(d2_load1(p), d2_set1(1.5));
    put_pair(out, WORD_PAIR_LOAD, lane, a);
    put_pair(out, WORD_PAIR_ADD, lane, d2_add(a, b));
    put_pair(out, WORD_PAIR_SUB, lane, d2_sub(a, d2_swap(a)));
    put_pair(out, WORD_PAIR_MUL, lane, d2_mul(a, b));
    put_pair(out, WORD_PAIR_MAX, lane, d2_max(a, b));
    put_pair(out, WORD_PAIR_ABS, lane, d2_abs(a));
    out->integers[WORD_PAIR_GT][lane] = d2_gt(a, b) | d2_gt(d2_swap(a), b) << 2;
}

/* Returns whether both are the same floats. */
static int put_four(struct word_output *out, int word, int lane, d4 four, d4 other)
{
    float rounded[3];
    const int are_same = d4_round(four, other, rounded);
    for (int i = 0; i < 3; ++i) out->values[word + i][lane] = rounded[i];
    return are_same;
}

static void run_four(const struct word_input *in, int lane, struct word_output *out)
{
    const float *p = in->a + lane, *q = in->b + lane, *r = in->b + (lane + 1) % WORD_LANES;
    const d4 a = d4_corner_terms(p, q, r, q, in->a + (lane + 5) % WORD_LANES), b = d4_lower(a), c = d4_upper(a);
    const d4 inverse = d4_inverse(a), near = d4_mul(a, d4_set1(1 + 0x1p-25));
    put_four(out, WORD_FOUR_TERMS, lane, a, a);
    put_four(out, WORD_FOUR_LOWER, lane, b, b);
    put_four(out, WORD_FOUR_UPPER, lane, c, c);
    put_four(out, WORD_FOUR_INVERSE, lane, inverse, inverse);
    put_four(out, WORD_FOUR_PRODUCT, lane, d4_sub(d4_mul(a, b), d4_add(d4_abs(b), c)), c);
    out->integers[WORD_FOUR_THIRD_GT][lane] = (uint32_t)d4_third_gt(a, c);
    out->integers[WORD_FOUR_ROUND][lane] = (uint32_t)put_four(out, WORD_FOUR_TERMS, lane, a, near);
    out->values[WORD_FOUR_ROUND][lane] = (float)d4_first(near);
}

static void run_quad(const struct word_input *in, int v, struct word_output *out)
{
    const f4 a = f4_load(in->a + v), b = f4_load(in->b + v);
    f4_store(out->values[WORD_QUAD_SET1] + v, f4_set1(in->a[v]));
    f4_store(out->values[WORD_QUAD_ADD] + v, f4_add(a, b));
    f4_store(out->values[WORD_QUAD_SUB] + v, f4_sub(a, b));
    f4_store(out->values[WORD_QUAD_MUL] + v, f4_mul(a, b));
    f4_store(out->values[WORD_QUAD_DIV] + v, f4_div(a, b));
    f4_store(out->values[WORD_QUAD_MAX] + v, f4_max(a, b));
    f4_store(out->values[WORD_QUAD_ABS] + v, f4_abs(a));
    f4_store(out->values[WORD_QUAD_FLIP] + v, f4_flip(a, in->lanes & 1 ? -1.0f : 1.0f));
    f4_store(out->values[WORD_QUAD_NEXT] + v, f4_next(a));
    f4_store(out->values[WORD_QUAD_JOIN] + v, f4_join(a, b));
    f4_store(out->values[WORD_QUAD_HIDE] + v, f4_max(f4_hide(a, b), f4_set1(-1)));
    MLRT_ALIGNED(16) int32_t whole[4];
    f4_store_whole(whole, f4_min(f4_abs(a), f4_set1(1000.75f)));
    for (int i = 0; i < 3; ++i) out->integers[WORD_QUAD_STORE_WHOLE][v + i] = (uint32_t)whole[i];
    f4_store_any(out->values[WORD_QUAD_ANY] + v, f4_load_any((const char *)in->a + 3 * v));
    for (unsigned i = 0, same = f4_same_words(in->bits_a + v, in->bits_b[v]); i < 4; ++i) {
        out->integers[WORD_QUAD_SAME_WORDS][(unsigned)v + i] = (same >> i & 1) | same >> 4;
    }
    for (unsigned i = 0; i < 4; ++i) {
        out->integers[WORD_QUAD_SIGNS][(unsigned)v + i] = (f4_signs(a) >> i & 1) | f4_signs(b) >> 4;
        out->integers[WORD_QUAD_ABOVE][(unsigned)v + i] = (f4_above(a, b) >> i & 1) | f4_above(b, a) >> 4;
    }
    f4_store(out->values[WORD_QUAD_LOW] + v, f4_low(a, b));
    f4_store(out->values[WORD_QUAD_HIGH] + v, f4_high(a, b));
    f4_store(out->values[WORD_QUAD_EVENS] + v, f4_evens(a, b));
    f4_store(out->values[WORD_QUAD_ODDS] + v, f4_odds(a, b));
    f4_store_low(out->values[WORD_QUAD_STORE_HALVES] + v, b);
    f4_store_high(out->values[WORD_QUAD_STORE_HALVES] + v + 2, a);
    out->values[WORD_QUAD_LAST][v] = f4_last(a);
    out->values[WORD_QUAD_LEAST_OF][v] = f4_least_of(a, in->b[v]) + 0.0f; /* -0 or 0, as below */
    out->values[WORD_QUAD_GREATEST_OF][v] = f4_greatest_of(a, in->b[v]) + 0.0f;
    for (int i = v; i < v + 4; ++i) {
        out->integers[WORD_QUAD_ARE_WITHIN][i] =
            (uint32_t)f4_are_within(f4_set1(in->a[i]), f4_set1(in->b[i]), 0x1p-60f, 0x1p60f);
    }
    if (in->has_order) {
        out->values[WORD_QUAD_HMIN][v] = f4_hmin(a) + 0.0f; /* of -0 and 0 either may be the least */
        out->values[WORD_QUAD_HMAX][v] = f4_hmax(a) + 0.0f;
    }
}

static void run_corners(const struct word_input *in, struct word_output *out)
{
    float corner[3][3];
    f4 by_axis[3];
    memcpy(corner, in->a + 1, sizeof corner);
    f4_corners((const float(*)[3])corner, by_axis);
    for (int k = 0; k < 3; ++k) f4_store(out->values[WORD_QUAD_CORNERS] + 4 * k, by_axis[k]);
}

static void run_least(const struct word_input *in, struct word_output *out)
{
    float least = INFINITY, greatest = -INFINITY;
    f4 least_of_four = f4_set1(INFINITY);
    for (int v = 0; v < WORD_LANES; v += VW) {
        least = fminf(least, v_hmin(v_load(in->a + v)));
        greatest = fmaxf(greatest, v_hmax(v_load(in->a + v)));
        const vf a = v_load(in->a + v);
        const f4 four = v_hmin4(a, v_flip(a, v_set1(-1)), v_abs(a), v_max(a, v_set1(3)));
        least_of_four = f4_add(f4_min(four, least_of_four), f4_set1(0));
    }
    f4_store(out->values[WORD_HMIN4], least_of_four);
    out->values[WORD_HMIN][0] = least + 0.0f;
    out->values[WORD_HMAX][0] = greatest + 0.0f;
}

void RUN_WORDS(const struct word_input *in, struct word_output *out)
{
    memset(out, 0, sizeof *out);
    for (int v = 0; v < WORD_LANES; v += VW) {
        run_vector(in, v, out);
        run_loads(in, v, out);
    }
    for (int lane = 0; lane < WORD_LANES; ++lane) {
        run_pair(in, lane, out);
        run_four(in, lane, out);
    }
    for (int v = 0; v < WORD_LANES; v += 4) run_quad(in, v, out);
    for (int lane = 0; lane < WORD_LANES; lane += DW) run_doubles(in, lane, out);
    run_blocks(in, out);
    run_rows(in, out);
    run_corners(in, out);
    if (in->has_order) run_least(in, out);
}
