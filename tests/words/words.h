/* SPDX-License-Identifier: MIT */
/*
 * Every word of a vocabulary (src/simd) on sixteen lanes: what test_simd.c compares
 * among the instruction sets. One object for each, compiled for it.
 */
#ifndef WORDS_H
#define WORDS_H

#include <stdint.h>

#include "base/platform.h"

#define WORD_LANES 16

struct word_input {
    MLRT_ALIGNED(64) float a[WORD_LANES];
    MLRT_ALIGNED(64) float b[WORD_LANES];
    MLRT_ALIGNED(64) uint32_t bits_a[WORD_LANES]; /* of a and b */
    MLRT_ALIGNED(64) uint32_t bits_b[WORD_LANES];
    uint32_t lanes; /* a bit each, and more above */
    int has_order;  /* no NaN among the lanes: only then least and greatest are looked at */
};

enum {
    WORD_SET1,
    WORD_ADD,
    WORD_SUB,
    WORD_MUL,
    WORD_DIV,
    WORD_MUL_ADD,     /* two roundings */
    WORD_AT_ONCE_ADD, /* one rounding, or two */
    WORD_AT_ONCE_SUB,
    WORD_MIN,
    WORD_MAX,
    WORD_ABS,
    WORD_FLIP,
    WORD_SELECT,
    WORD_HMIN,
    WORD_HMAX,
    WORD_HMIN4,
    WORD_LOAD_ANY,
    WORD_TRIPLES, /* by axis: three */
    WORD_TRIPLES_END = WORD_TRIPLES + 2,
    WORD_TRIPLES_AT,
    WORD_TRIPLES_AT_END = WORD_TRIPLES_AT + 2,
    WORD_QUADS_AT, /* by word: four */
    WORD_QUADS_AT_END = WORD_QUADS_AT + 3,
    WORD_FLOATS_AT, /* side by side, and apart */
    WORD_FLOATS_AT_END = WORD_FLOATS_AT + 1,
    WORD_PAIRS_AT, /* firsts, seconds */
    WORD_PAIRS_AT_END = WORD_PAIRS_AT + 1,
    WORD_STORE_ROWS, /* four rows */
    WORD_STORE_ROWS_END = WORD_STORE_ROWS + 3,
    WORD_INTEGER_SET1,
    WORD_INTEGER_SELECT,
    WORD_INTEGER_LOAD_ANY,
    WORD_INTEGER_SUB,
    /* masks: 0 or 1 in each lane */
    WORD_LT,
    WORD_LE,
    WORD_GT,
    WORD_GE,
    WORD_EQ,
    WORD_INTEGER_EQ,
    WORD_INTEGER_LT,
    WORD_FROM_BITS,
    WORD_AND,
    WORD_OR,
    WORD_AND_NOT,
    /* doubles, rounded to floats */
    WORD_DOUBLE_SET1,
    WORD_DOUBLE_LOAD,
    WORD_DOUBLE_ADD,
    WORD_DOUBLE_SUB,
    WORD_DOUBLE_MUL,
    WORD_DOUBLE_DIV,
    WORD_DOUBLE_MUL_ADD,
    WORD_DOUBLE_ABS,
    WORD_DOUBLE_MAX,
    WORD_DOUBLE_FLIP,
    WORD_DOUBLE_GT,
    WORD_DOUBLE_SAME_FLOAT,
    /* two doubles, and three of four, rounded to floats */
    WORD_PAIR_LOAD,
    WORD_PAIR_ADD = WORD_PAIR_LOAD + 2,
    WORD_PAIR_SUB = WORD_PAIR_ADD + 2,
    WORD_PAIR_MUL = WORD_PAIR_SUB + 2,
    WORD_PAIR_MAX = WORD_PAIR_MUL + 2,
    WORD_PAIR_ABS = WORD_PAIR_MAX + 2,
    WORD_PAIR_GT = WORD_PAIR_ABS + 2,
    WORD_FOUR_TERMS,
    WORD_FOUR_LOWER = WORD_FOUR_TERMS + 3,
    WORD_FOUR_UPPER = WORD_FOUR_LOWER + 3,
    WORD_FOUR_INVERSE = WORD_FOUR_UPPER + 3,
    WORD_FOUR_PRODUCT = WORD_FOUR_INVERSE + 3,
    WORD_FOUR_THIRD_GT = WORD_FOUR_PRODUCT + 3,
    WORD_FOUR_ROUND,
    /* four at a time */
    WORD_QUAD_SET1,
    WORD_QUAD_ADD,
    WORD_QUAD_SUB,
    WORD_QUAD_MUL,
    WORD_QUAD_DIV,
    WORD_QUAD_MAX,
    WORD_QUAD_ABS,
    WORD_QUAD_FLIP,
    WORD_QUAD_NEXT,
    WORD_QUAD_JOIN,
    WORD_QUAD_HIDE,
    WORD_QUAD_STORE_WHOLE,
    WORD_QUAD_LAST,
    WORD_QUAD_HMIN,
    WORD_QUAD_HMAX,
    WORD_QUAD_LEAST_OF,
    WORD_QUAD_GREATEST_OF,
    WORD_QUAD_ARE_WITHIN,
    WORD_QUAD_CORNERS,
    WORD_QUAD_ANY,
    WORD_QUAD_SAME_WORDS,
    WORD_QUAD_SIGNS,
    WORD_QUAD_ABOVE,
    WORD_QUAD_LOW,
    WORD_QUAD_HIGH,
    WORD_QUAD_EVENS,
    WORD_QUAD_ODDS,
    WORD_QUAD_STORE_HALVES,
    WORD_COUNT
};

/* By word; each fills one of the two. */
struct word_output {
    MLRT_ALIGNED(64) float values[WORD_COUNT][WORD_LANES];
    MLRT_ALIGNED(64) uint32_t integers[WORD_COUNT][WORD_LANES];
};

typedef void run_words(const struct word_input *in, struct word_output *out);

run_words run_words_scalar, run_words_sse, run_words_avx2, run_words_avx512, run_words_neon;

#endif
