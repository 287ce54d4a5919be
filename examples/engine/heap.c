/* SPDX-License-Identifier: MIT */
/* heap.c - the engine's own memory: see heap.h */
#define _POSIX_C_SOURCE 200112L
#include "engine/heap.h"

#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 }; // the most that the library asks for

struct free_block {
    struct free_block *next;
};

// Sizes are rounded up to n 2^s with n = 1..8 and s >= 6, so at most a fifth is lost, and blocks fit again.
static unsigned size_class(size_t *size)
{
    unsigned shift = 6;
    while ((*size - 1) >> shift >= 8) shift++;
    const size_t steps = ((*size - 1) >> shift) + 1;
    *size = steps << shift;
    return shift * 8 + (unsigned)steps - 1;
}

void heap_begin(struct heap *heap)
{
    memset(heap, 0, sizeof *heap);
    pthread_mutex_init(&heap->mutex, NULL);
}

void *heap_allocate(void *user, size_t size, size_t alignment)
{
    struct heap *heap = user;
    if (alignment > ALIGNMENT || size > SIZE_MAX / 2) return NULL;
    const unsigned class = size_class(&size);
    void *block = NULL;
    pthread_mutex_lock(&heap->mutex);
    if (heap->free_blocks[class]) {
        block = heap->free_blocks[class];
        heap->free_blocks[class] = heap->free_blocks[class]->next;
    } else if (posix_memalign(&block, ALIGNMENT, size) == 0) {
        heap->system_call_count++;
    } else {
        block = NULL;
    }
    if (block) heap->held_size += size;
    if (heap->held_size > heap->peak_size) heap->peak_size = heap->held_size;
    pthread_mutex_unlock(&heap->mutex);
    return block;
}

// The library says how large its block was, so that no header is needed before it.
void heap_free(void *user, void *block, size_t size, size_t alignment)
{
    struct heap *heap = user;
    struct free_block *freed = block;
    (void)alignment;
    if (!block) return;
    const unsigned class = size_class(&size);
    pthread_mutex_lock(&heap->mutex);
    freed->next = heap->free_blocks[class];
    heap->free_blocks[class] = freed;
    heap->held_size -= size;
    pthread_mutex_unlock(&heap->mutex);
}

void heap_trim(struct heap *heap)
{
    pthread_mutex_lock(&heap->mutex);
    for (unsigned class = 0; class < HEAP_CLASS_COUNT; class ++) {
        while (heap->free_blocks[class]) {
            struct free_block *block = heap->free_blocks[class];
            heap->free_blocks[class] = block->next;
            free(block);
        }
    }
    pthread_mutex_unlock(&heap->mutex);
}

void heap_end(struct heap *heap)
{
    heap_trim(heap);
    pthread_mutex_destroy(&heap->mutex);
}

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

void *stack_allocate(void *user, size_t size, size_t alignment)
{
    struct stack *stack = user;
    if (alignment > ALIGNMENT || size > stack->size - stack->top || round_up(size) > stack->size - stack->top)
        return NULL;
    void *block = stack->start + stack->top;
    stack->top += round_up(size);
    if (stack->top > stack->peak_size) stack->peak_size = stack->top;
    return block;
}

void stack_free(void *user, void *block, size_t size, size_t alignment)
{
    struct stack *stack = user;
    (void)alignment;
    if ((unsigned char *)block + round_up(size) == stack->start + stack->top) stack->top -= round_up(size);
}
