/* SPDX-License-Identifier: MIT */
/*
 * The words of the kernels mean the same in every instruction set: each against plain C, bit for bit, on all pairs of
 * special values in all lanes.
 */
#include "support.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "words/words.h"

static const char *const names[WORD_COUNT] = {"v_set1",         "v_add",          "v_sub",
                                              "v_mul",          "v_div",          "v_mul and v_add",
                                              "v_mul_add",      "v_mul_sub",      "v_min",
                                              "v_max",          "v_abs",          "v_flip, v_opposite",
                                              "v_select",       "v_hmin",         "v_hmax",
                                              "v_hmin4",        "v_load_any",     "v_triples",
                                              "v_triples",      "v_triples",      "v_triples_at",
                                              "v_triples_at",   "v_triples_at",   "v_quads_at",
                                              "v_quads_at",     "v_quads_at",     "v_quads_at",
                                              "v_floats_at",    "v_floats_at",    "i_pairs_at",
                                              "i_pairs_at",     "v_store_rows",   "v_store_rows",
                                              "v_store_rows",   "v_store_rows",   "i_set1",
                                              "i_select",       "i_load_any",     "i_sub, i_and",
                                              "v_lt",           "v_le",           "v_gt",
                                              "v_ge",           "v_eq",           "i_eq",
                                              "i_lt",           "m_from_bits",    "m_and",
                                              "m_or",           "m_andnot",       "d_set1",
                                              "d_load",         "d_add",          "d_sub",
                                              "d_mul",          "d_div",          "d_mul and d_sub",
                                              "d_abs",          "d_max",          "d_flip",
                                              "d_gt",           "d_same_float",   "d2_load",
                                              "d2_load",        "d2_add",         "d2_add",
                                              "d2_sub",         "d2_sub",         "d2_mul",
                                              "d2_mul",         "d2_max",         "d2_max",
                                              "d2_abs",         "d2_abs",         "d2_gt",
                                              "d4 terms",       "d4 terms",       "d4 terms",
                                              "d4_lower",       "d4_lower",       "d4_lower",
                                              "d4_upper",       "d4_upper",       "d4_upper",
                                              "d4_inverse",     "d4_inverse",     "d4_inverse",
                                              "d4 arithmetic",  "d4 arithmetic",  "d4 arithmetic",
                                              "d4_third_gt",    "d4_round",       "f4_set1",
                                              "f4_add",         "f4_sub",         "f4_mul",
                                              "f4_div",         "f4_max",         "f4_abs",
                                              "f4_flip",        "f4_next",        "f4_join",
                                              "f4_hide",        "f4_store_whole", "f4_last",
                                              "f4_hmin",        "f4_hmax",        "f4_least_of",
                                              "f4_greatest_of", "f4_are_within",  "f4_corners",
                                              "f4_load_any",    "f4_same_words",  "f4_signs",
                                              "f4_above",       "f4_low",         "f4_high",
                                              "f4_evens",       "f4_odds",        "f4_store_low, high"};

static const float special[] = {0,
                                -0.0f,
                                1,
                                -1,
                                NAN,
                                -NAN,
                                INFINITY,
                                -INFINITY,
                                0x1p-149f,
                                -0x1p-149f,
                                0x1.fffffcp-127f,
                                FLT_MIN,
                                -FLT_MIN,
                                FLT_MAX,
                                -FLT_MAX,
                                3,
                                0x1p-75f,
                                0x1.000002p0f,
                                0x1.fffffep-1f,
                                -0x1.8p64f,
                                0x1p-60f,
                                0x1p60f,
                                0.1f};

#define SPECIAL_COUNT (sizeof special / sizeof special[0])

/* Which NaN an operation makes is not said. */
static int is_arithmetic(int word)
{
    return (word >= WORD_ADD && word <= WORD_AT_ONCE_SUB) || (word >= WORD_DOUBLE_SET1 && word <= WORD_DOUBLE_ABS) ||
           (word >= WORD_PAIR_LOAD && word <= WORD_FOUR_ROUND) || (word >= WORD_QUAD_ADD && word <= WORD_QUAD_DIV);
}

/* A product and a sum may have one rounding in place of two. */
static int is_fused(int word, float a, float b, float found)
{
    if (word != WORD_AT_ONCE_ADD && word != WORD_AT_ONCE_SUB) return 0;
    const float fused = fmaf(a, b, word == WORD_AT_ONCE_ADD ? a : -a);
    return memcmp(&fused, &found, sizeof fused) == 0;
}

static void compare(const struct word_input *in, const struct word_output *expected, const struct word_output *found)
{
    for (int word = 0; word < WORD_COUNT; ++word) {
        for (int lane = 0; lane < WORD_LANES; ++lane) {
            const float x = expected->values[word][lane], y = found->values[word][lane];
            const uint32_t i = expected->integers[word][lane], j = found->integers[word][lane];
            if (i == j && (memcmp(&x, &y, sizeof x) == 0 || (is_arithmetic(word) && isnan(x) && isnan(y)))) continue;
            if (is_fused(word, in->a[lane], in->b[lane], y)) continue;
            fail_msg("%s of %a and %a in lane %d is %a, %u; in plain C %a, %u", names[word], (double)in->a[lane],
                     (double)in->b[lane], lane, (double)y, (unsigned)j, (double)x, (unsigned)i);
        }
    }
}

static void check_words(run_words *run)
{
    struct random random = {3};
    for (size_t first = 0; first < SPECIAL_COUNT; ++first) {
        for (size_t second = 0; second < SPECIAL_COUNT; ++second) {
            struct word_input in = {.lanes = draw_bits(&random), .has_order = 1};
            struct word_output expected, found;
            for (size_t i = 0; i < WORD_LANES; ++i) {
                in.a[i] = special[(first + i) % SPECIAL_COUNT];
                in.b[i] = special[(second + 3 * i) % SPECIAL_COUNT];
                if (isnan(in.a[i])) in.has_order = 0;
            }
            memcpy(in.bits_a, in.a, sizeof in.a);
            memcpy(in.bits_b, in.b, sizeof in.b);
            run_words_scalar(&in, &expected);
            run(&in, &found);
            compare(&in, &expected, &found);
        }
    }
}

static void the_words_mean_the_same(void **state)
{
    (void)state;
    check_words(run_words_scalar);
#if MLRT_SSE_KERNELS
    check_words(run_words_sse);
    if (isa_is_supported(MLRT_ISA_AVX2)) check_words(run_words_avx2);
    if (isa_is_supported(MLRT_ISA_AVX512)) check_words(run_words_avx512);
#elif MLRT_NEON_KERNELS
    check_words(run_words_neon);
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_words_mean_the_same)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
