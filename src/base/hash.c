/* SPDX-License-Identifier: MIT */
/*
 * The hash of words: see hash.h.
 *
 * In step i, lane j of eight takes a 64-bit value: word 16 i + 2 j is its lower half, word 16 i + 2 j + 1 its upper
 * half. Zeros fill up the last block. At the end the number of words and all lanes are hashed into one value. No lane
 * waits for the multiplication of another: 4 bytes per clock cycle and more.
 *
 * For a given value a step is a bijection of the lane, and for a given lane a bijection of the value: so inputs that
 * differ in one word end with different lanes. A step multiplies, adds, rotates and multiplies, as Y. Collet's xxHash
 * does.
 */
#include "base/hash.h"

#include <string.h>

/* Odd, with irregular bits: 2^64 divided by the golden ratio, and a factor of G. Steele and S. Vigna, 2021. */
#define FACTOR       0x9E3779B97F4A7C15u
#define OTHER_FACTOR 0xD1342543DE82EF95u

#define BLOCK_WORDS (2 * MLRT_HASH_LANES)

static inline uint64_t take(uint64_t lane, uint64_t value)
{
    lane += value * OTHER_FACTOR;
    lane = lane << 31 | lane >> 33;
    return lane * FACTOR;
}

static inline void take_block(uint64_t lane[MLRT_HASH_LANES], const uint32_t words[BLOCK_WORDS])
{
    for (int j = 0; j < MLRT_HASH_LANES; ++j) lane[j] = take(lane[j], words[2 * j] | (uint64_t)words[2 * j + 1] << 32);
}

void mlrt_start_hash(struct mlrt_hash *hash)
{
    for (uint64_t j = 0; j < MLRT_HASH_LANES; ++j) hash->lane[j] = j * FACTOR;
    hash->word_count = 0;
}

void mlrt_add_words(struct mlrt_hash *hash, const void *words, size_t count)
{
    const unsigned char *next = words;
    uint64_t lane[MLRT_HASH_LANES];
    memcpy(lane, hash->lane, sizeof lane);
    while (count > 0) {
        const uint32_t waiting = (uint32_t)(hash->word_count % BLOCK_WORDS);
        const size_t room = BLOCK_WORDS - waiting, taken = count < room ? count : room;
        memcpy(hash->waiting + waiting, next, 4 * taken);
        hash->word_count += taken;
        if (taken == room) take_block(lane, hash->waiting);
        next += 4 * taken;
        count -= taken;
    }
    memcpy(hash->lane, lane, sizeof lane);
}

uint64_t mlrt_finish_hash(struct mlrt_hash *hash)
{
    static const uint32_t zeros[BLOCK_WORDS];
    uint64_t all = hash->word_count;
    mlrt_add_words(hash, zeros, (BLOCK_WORDS - all % BLOCK_WORDS) % BLOCK_WORDS);
    for (int j = 0; j < MLRT_HASH_LANES; ++j) all = take(all, hash->lane[j]);
    all = (all ^ all >> 32) * FACTOR;
    return all ^ all >> 29;
}
