/* SPDX-License-Identifier: MIT */
/*
 * heap.h - the engine's own memory: a heap with free lists for long-lived blocks, and a stack for those of one tile
 *
 * Both have functions that fit mlrt_host. Several threads may use the heap at once; a stack belongs to one worker.
 */
#ifndef ENGINE_HEAP_H
#define ENGINE_HEAP_H

#include <pthread.h>
#include <stddef.h>
#include <stdint.h>

enum { HEAP_CLASS_COUNT = 64 * 8 };

struct heap {
    pthread_mutex_t mutex;
    struct free_block *free_blocks[HEAP_CLASS_COUNT]; // of each size, to be used again
    size_t held_size, peak_size;                      // bytes handed out
    uint64_t system_call_count;                       // blocks that came from the system
};

void heap_begin(struct heap *heap);
void *heap_allocate(void *heap, size_t size, size_t alignment);
void heap_free(void *heap, void *block, size_t size, size_t alignment);

/* Returns free blocks to the system. */
void heap_trim(struct heap *heap);

/* Likewise, and the heap ends. Nothing may be held any more: see held_size. */
void heap_end(struct heap *heap);

/* Only the last block allocated can be used again before the owner sets `top` back. */
struct stack {
    unsigned char *start; // aligned to 64
    size_t size, top, peak_size;
};

void *stack_allocate(void *stack, size_t size, size_t alignment);
void stack_free(void *stack, void *block, size_t size, size_t alignment);

#endif
