/* SPDX-License-Identifier: MIT */
/*
 * Memory: blocks aligned to 64 bytes, from the host or from malloc, with sizes checked and counted.
 *
 * C99 has no aligned allocation, so a block from malloc is larger by MARGIN_SIZE. The aligned block lies inside it, and
 * the address that malloc returned is stored just below the aligned one. The margin is not counted.
 */
#define _DEFAULT_SOURCE
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#include "base/message.h"
#include "base/platform.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

/* A cache line, and the widest vector of any instruction set. */
#define ALIGNMENT 64

/* Added to each block: the way to the next aligned address, and the stored address below it. */
#define MARGIN_SIZE (ALIGNMENT + sizeof(void *))

static int product_fits(size_t count, size_t size)
{
    return size == 0 || count <= (SIZE_MAX - MARGIN_SIZE) / size;
}

/* The bytes of a block: at least 1, as a host is never asked for none. */
static size_t block_size_of(size_t count, size_t size)
{
    return count && size ? count * size : 1;
}

static int within_limit(const struct mlrt_memory *memory, size_t block_size)
{
    return memory->limit_size == 0 ||
           (memory->held_size <= memory->limit_size && block_size <= memory->limit_size - memory->held_size);
}

/* Stores the address that malloc returned below the aligned block inside. Returns the aligned block. */
static void *place_block(char *start)
{
    char *lowest = start + sizeof(void *);
    char *block = lowest + (ALIGNMENT - (uintptr_t)lowest % ALIGNMENT) % ALIGNMENT;
    memcpy(block - sizeof(void *), &start, sizeof(void *));
    return block;
}

/* The address that malloc returned for this block. */
static char *start_of(const void *block)
{
    char *start;
    memcpy(&start, (const char *)block - sizeof(void *), sizeof(void *));
    return start;
}

/*
 * Large pages have 2 MiB on x86 and most other processors. A block of less than two of them may hold none that is
 * aligned.
 */
#define LARGE_PAGE_SIZE  ((size_t)1 << 21)
#define LARGE_BLOCK_SIZE (2 * LARGE_PAGE_SIZE)

/*
 * Asks the system for large pages inside a large block: traversal reads a tree in no order, and each small page costs
 * a look-up in the page tables. The system need not follow the hint; only time depends on it.
 */
static void advise_large_pages(char *start, size_t size)
{
#if defined(MADV_HUGEPAGE)
    if (size < LARGE_BLOCK_SIZE) return;
    size_t skipped = (LARGE_PAGE_SIZE - (uintptr_t)start % LARGE_PAGE_SIZE) % LARGE_PAGE_SIZE;
    madvise(start + skipped, (size - skipped) / LARGE_PAGE_SIZE * LARGE_PAGE_SIZE, MADV_HUGEPAGE);
#else
    (void)start;
    (void)size;
#endif
}

static void count_held(struct mlrt_memory *memory, size_t added_size)
{
    memory->held_size += added_size;
    if (memory->held_size > memory->peak_size) memory->peak_size = memory->held_size;
}

struct mlrt_memory mlrt_host_memory(const mlrt_host *host, uint64_t limit_size)
{
    return (struct mlrt_memory){0, 0, limit_size, host->user, host->allocate, host->free};
}

/* What the host's function calls may fail: the message of the thread remains that of the call for which it frees. */
static MLRT_NOINLINE void free_by_host(const struct mlrt_memory *memory, void *block, size_t size)
{
    char kept[MLRT_MESSAGE_SIZE], *message = mlrt_message_of_thread();
    memcpy(kept, message, sizeof kept);
    memory->free(memory->user, block, size, ALIGNMENT);
    memcpy(message, kept, sizeof kept);
}

/* A block from the host. A block that is not aligned is freed at once; then the result is NULL. */
static void *allocate_from_host(const struct mlrt_memory *memory, size_t size)
{
    void *block = memory->allocate(memory->user, size, ALIGNMENT);
    if (block == NULL || (uintptr_t)block % ALIGNMENT == 0) return block;
    free_by_host(memory, block, size);
    return NULL;
}

static void *allocate_from_system(size_t block_size)
{
    char *start = malloc(block_size + MARGIN_SIZE);
    if (start == NULL) return NULL;
    advise_large_pages(start, block_size);
    return place_block(start);
}

void *mlrt_allocate(struct mlrt_memory *memory, size_t count, size_t size)
{
    if (!product_fits(count, size)) return NULL;
    const size_t block_size = block_size_of(count, size);
    if (!within_limit(memory, block_size)) return NULL;
    void *block = memory->allocate ? allocate_from_host(memory, block_size) : allocate_from_system(block_size);
    if (block != NULL) count_held(memory, block_size);
    return block;
}

void *mlrt_allocate_zeroed(struct mlrt_memory *memory, size_t count, size_t size)
{
    void *block = mlrt_allocate(memory, count, size);
    if (block != NULL) memset(block, 0, count * size);
    return block;
}

void mlrt_free(struct mlrt_memory *memory, void *block, size_t count, size_t size)
{
    const size_t block_size = block_size_of(count, size);
    if (block == NULL) return;
    memory->held_size -= block_size;
    if (memory->free)
        free_by_host(memory, block, block_size);
    else
        free(start_of(block));
}

/* Where there is no realloc. The old block is held until the new one is filled. */
static void *move_block(struct mlrt_memory *memory, void *block, size_t old_count, size_t new_count, size_t size)
{
    void *moved = mlrt_allocate(memory, new_count, size);
    if (moved == NULL) return NULL;
    memcpy(moved, block, (old_count < new_count ? old_count : new_count) * size);
    mlrt_free(memory, block, old_count, size);
    return moved;
}

/*
 * realloc keeps the distance of the bytes from its own start. The distance from the new start to the next aligned
 * address can be another, so the bytes are moved there.
 */
void *mlrt_resize(struct mlrt_memory *memory, void *block, size_t old_count, size_t new_count, size_t size)
{
    if (block == NULL) return mlrt_allocate(memory, new_count, size);
    if (memory->allocate) return move_block(memory, block, old_count, new_count, size);
    if (!product_fits(new_count, size)) return NULL;
    const size_t old_size = block_size_of(old_count, size), new_size = block_size_of(new_count, size);
    const size_t kept_size = old_size < new_size ? old_size : new_size;
    if (!within_limit(memory, new_size - kept_size)) return NULL;
    size_t old_offset = (size_t)((char *)block - start_of(block));
    char *start = realloc(start_of(block), new_size + MARGIN_SIZE);
    if (start == NULL) return NULL;
    advise_large_pages(start, new_size);
    size_t lowest = (uintptr_t)start % ALIGNMENT + sizeof(void *);
    size_t new_offset = sizeof(void *) + (ALIGNMENT - lowest % ALIGNMENT) % ALIGNMENT;
    if (new_offset != old_offset) memmove(start + new_offset, start + old_offset, kept_size);
    memory->held_size -= old_size;
    count_held(memory, new_size);
    return place_block(start);
}

void *mlrt_reuse(struct mlrt_memory *memory, void *block, size_t old_size, size_t new_size)
{
    void *smaller = memory->allocate || new_size > old_size ? NULL : mlrt_resize(memory, block, old_size, new_size, 1);
    if (smaller) return smaller;
    mlrt_free(memory, block, old_size, 1);
    return mlrt_allocate(memory, new_size, 1);
}
