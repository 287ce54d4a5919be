/* SPDX-License-Identifier: MIT */
/*
 * A 64-bit hash of 32-bit words, to detect that data have changed. It is defined on the values of the words, so floats
 * and counts have the same hash on every machine. A change of one word always changes the hash; any other change leaves
 * it as it is with probability 2^-64. It gives no protection against data that are made to have a given hash.
 */
#ifndef MLRT_BASE_HASH_H
#define MLRT_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define MLRT_HASH_LANES 8

struct mlrt_hash {
    uint64_t lane[MLRT_HASH_LANES];
    uint32_t waiting[2 * MLRT_HASH_LANES]; /* the words of the last block, which is not full */
    uint64_t word_count;
};

void mlrt_start_hash(struct mlrt_hash *hash);

/* Adds `count` words, at any address. The hash does not depend on how many are added at a time. */
void mlrt_add_words(struct mlrt_hash *hash, const void *words, size_t count);

/* Returns the hash of all words added. */
uint64_t mlrt_finish_hash(struct mlrt_hash *hash);

#endif
