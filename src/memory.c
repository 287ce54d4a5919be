/* SPDX-License-Identifier: MIT */
/*
 * Memory: blocks aligned to 64 bytes, with the sizes checked and counted.
 *
 * C99 has no aligned allocation, so a block is cut out of a larger one from malloc, whose address lies just below it.
 * Counted are the bytes asked for, without that margin.
 */
#include "memory.h"

#include <stdlib.h>
#include <string.h>

/* A cache line, and the widest vector of any instruction set. */
#define ALIGNMENT 64

/* What is added to a block: room to move it up to the next aligned address, and the address to free below it. */
#define MARGIN_SIZE (ALIGNMENT + sizeof(void *))

static int product_fits(size_t count, size_t size)
{
    return size == 0 || count <= (SIZE_MAX - MARGIN_SIZE) / size;
}

static int within_limit(const struct mlrt_memory *memory, size_t block_size)
{
    return memory->limit_size == 0 ||
           (memory->held_size <= memory->limit_size && block_size <= memory->limit_size - memory->held_size);
}

void *mlrt_allocate(struct mlrt_memory *memory, size_t count, size_t size)
{
    if (!product_fits(count, size) || !within_limit(memory, count * size))
        return NULL;
    char *start = malloc(count * size + MARGIN_SIZE);
    if (start == NULL)
        return NULL;
    char *lowest = start + sizeof(void *);
    char *block = lowest + (ALIGNMENT - (uintptr_t)lowest % ALIGNMENT) % ALIGNMENT;
    memcpy(block - sizeof(void *), &start, sizeof(void *));
    memory->held_size += count * size;
    if (memory->held_size > memory->peak_size)
        memory->peak_size = memory->held_size;
    return block;
}

void mlrt_free(struct mlrt_memory *memory, void *block, size_t count, size_t size)
{
    if (block == NULL)
        return;
    void *start;
    memcpy(&start, (char *)block - sizeof(void *), sizeof(void *));
    free(start);
    memory->held_size -= count * size;
}

void *mlrt_resize(struct mlrt_memory *memory, void *block, size_t old_count, size_t new_count, size_t size)
{
    void *resized = mlrt_allocate(memory, new_count, size);
    if (resized == NULL)
        return NULL;
    if (block != NULL)
        memcpy(resized, block, (old_count < new_count ? old_count : new_count) * size);
    mlrt_free(memory, block, old_count, size);
    return resized;
}
