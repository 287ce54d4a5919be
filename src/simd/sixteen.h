/* SPDX-License-Identifier: MIT */
/*
 * Sixteen words: numbers of triangles, one for each ray of a packet, or each cell.
 */
#ifndef MLRT_SIMD_SIXTEEN_H
#define MLRT_SIMD_SIXTEEN_H

#include <stdint.h>

#include "mlrt.h"

/* Which of them are `word`: bit per place. */
uint32_t mlrt_same_words(const uint32_t words[16], uint32_t word);

/* Makes all of them `word`. */
void mlrt_fill_words(uint32_t words[16], uint32_t word);

#endif
