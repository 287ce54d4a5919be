/* SPDX-License-Identifier: MIT */
/* Sixteen words, four at a time: see sixteen.h. */
#include "simd/sixteen.h"

#include "simd/quad.h"

uint32_t mlrt_same_words(const uint32_t words[16], uint32_t word)
{
    uint32_t same = 0;
    for (int i = 0; i < 16; i += 4) same |= (uint32_t)f4_same_words(words + i, word) << i;
    return same;
}

void mlrt_fill_words(uint32_t words[16], uint32_t word)
{
    const uint32_t four[4] = {word, word, word, word};
    const f4 quad = f4_load_any(four);
    for (int i = 0; i < 16; i += 4) f4_store_any(words + i, quad);
}
