/* SPDX-License-Identifier: MIT */
/*
 * A hash of 64 bits over 32-bit words, many at a time, to tell whether data are what they were. It is defined on the
 * values of the words, so floats and counts have the same hash on every machine. A change of one word always shows, any
 * other by chance 2^64 - 1 times in 2^64. It is no protection against someone who wants two data to have one hash.
 */
#ifndef MLRT_BASE_HASH_H
#define MLRT_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define MLRT_HASH_LANES 8

struct mlrt_hash {
    uint64_t lane[MLRT_HASH_LANES];
    uint32_t waiting[2 * MLRT_HASH_LANES]; /* words of a block that is not full */
    uint64_t word_count;
};

void mlrt_start_hash(struct mlrt_hash *hash);

/* Adds `count` words, at any address. How many are added at a time makes no difference. */
void mlrt_add_words(struct mlrt_hash *hash, const void *words, size_t count);

uint64_t mlrt_finish_hash(struct mlrt_hash *hash);

#endif
