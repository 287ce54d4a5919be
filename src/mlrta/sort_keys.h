/* SPDX-License-Identifier: MIT */
/* Floats as keys: unsigned integers of the same order, which are sorted by their digits. */
#ifndef MLRT_MLRTA_SORT_KEYS_H
#define MLRT_MLRTA_SORT_KEYS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/platform.h"

/* The key of a float: as unsigned integers, keys have the order of their floats. */
MLRT_INLINE uint32_t mlrt_float_key(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/* The float of a key. */
MLRT_INLINE float mlrt_key_float(uint32_t key)
{
    uint32_t bits = key & 0x80000000u ? key & 0x7FFFFFFFu : ~key;
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Sorts `count` keys ascending; `spare` has room for as many. */
void mlrt_sort_keys(uint32_t *keys, uint32_t *spare, size_t count);

/* Likewise, and keeps one of equal keys. Returns the number of those kept. */
size_t mlrt_sort_unique_keys(uint32_t *keys, uint32_t *spare, size_t count);

#endif
