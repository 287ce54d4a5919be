/* SPDX-License-Identifier: MIT */
/* Sixteen words, such as the numbers of triangles of a packet's rays or of a bundle's cells. */
#ifndef MLRT_SIMD_SIXTEEN_H
#define MLRT_SIMD_SIXTEEN_H

#include <stdint.h>

/* Returns the places whose words are `word`, one bit each. */
uint32_t mlrt_same_words(const uint32_t words[16], uint32_t word);

/* Sets all sixteen words to `word`. */
void mlrt_fill_words(uint32_t words[16], uint32_t word);

#endif
