/* SPDX-License-Identifier: MIT */
/*
 * Memory of a tree: blocks of count times size bytes, checked for overflow and counted.
 *
 * A `struct mlrt_memory` counts what is held through it, so that a build can report its peak.
 */
#ifndef MLRT_BASE_MEMORY_H
#define MLRT_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

#include "mlrt.h"

struct mlrt_memory {
    uint64_t held_size;  /* bytes allocated and not yet freed */
    uint64_t peak_size;  /* the largest held_size so far */
    uint64_t limit_size; /* held_size may not exceed it. 0 = no limit */
    /* The host's functions; NULL = malloc and free. */
    void *user;
    mlrt_allocate_callback allocate;
    mlrt_free_callback free;
};

/* Nothing held yet; blocks come from this host, which was checked. */
struct mlrt_memory mlrt_host_memory(const mlrt_host *host, uint64_t limit_size);

/* What something is expected to need. */
struct mlrt_demand {
    uint64_t held_size;
    uint64_t peak_size;
};

/* count * size bytes, aligned to 64, or NULL if there is no memory or the product overflows. count = 0 gives memory
 * too. */
void *mlrt_allocate(struct mlrt_memory *memory, size_t count, size_t size);

/* The same, all zero. */
void *mlrt_allocate_zeroed(struct mlrt_memory *memory, size_t count, size_t size);

/* Frees what mlrt_allocate(memory, count, size) returned; `count` and `size` are those given then. NULL is allowed. */
void mlrt_free(struct mlrt_memory *memory, void *block, size_t count, size_t size);

/*
 * Grows (or shrinks) an array from old_count to new_count elements, keeping the common part. On failure returns NULL
 * and the old block stays as it is.
 */
void *mlrt_resize(struct mlrt_memory *memory, void *block, size_t old_count, size_t new_count, size_t size);

#endif
