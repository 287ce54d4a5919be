/* SPDX-License-Identifier: MIT */
/*
 * Memory of trees, pools and calls: blocks of count * size bytes, from the host or from malloc, checked for overflow. A
 * `struct mlrt_memory` counts the bytes allocated through it, so that a build can report its peak.
 */
#ifndef MLRT_BASE_MEMORY_H
#define MLRT_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

#include "mlrt.h"

struct mlrt_memory {
    uint64_t held_size;  /* bytes allocated and not yet freed */
    uint64_t peak_size;  /* the largest held_size so far */
    uint64_t limit_size; /* held_size must not exceed it. 0 = no limit */
    /* The host's functions; NULL = malloc and free. */
    void *user;
    mlrt_allocate_callback allocate;
    mlrt_free_callback free;
};

/* A memory that holds nothing yet and takes its blocks from `host`, which was checked. limit_size: 0 = no limit. */
struct mlrt_memory mlrt_host_memory(const mlrt_host *host, uint64_t limit_size);

/* The bytes that a structure is expected to need: when it is finished, and at most while it is built. */
struct mlrt_demand {
    uint64_t held_size;
    uint64_t peak_size;
};

/*
 * Returns count * size bytes, aligned to 64. NULL if the product overflows, the limit would be exceeded, or there is
 * no memory. With count = 0 the result is a block too.
 */
void *mlrt_allocate(struct mlrt_memory *memory, size_t count, size_t size);

/* As mlrt_allocate, with all bytes 0. */
void *mlrt_allocate_zeroed(struct mlrt_memory *memory, size_t count, size_t size);

/* Frees a block (or NULL); `count` and `size` are those that mlrt_allocate or mlrt_resize was given. */
void mlrt_free(struct mlrt_memory *memory, void *block, size_t count, size_t size);

/*
 * Grows or shrinks an array from old_count to new_count elements, keeping the elements that both have. Returns the new
 * block, or NULL on failure; then the old block stays as it is.
 */
void *mlrt_resize(struct mlrt_memory *memory, void *block, size_t old_count, size_t new_count, size_t size);

/*
 * Frees a block of old_size bytes and allocates one of new_size, if possible in the same pages: the system clears pages
 * before they are first used, which takes long. Returns NULL on failure; the old block is freed then, too.
 */
void *mlrt_reuse(struct mlrt_memory *memory, void *block, size_t old_size, size_t new_size);

#endif
