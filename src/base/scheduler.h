/* SPDX-License-Identifier: MIT */
/*
 * The scheduler: shares out numbered work items among the workers of a pool.
 *
 * Every item 0 .. item_count - 1 runs exactly once, on one worker, which can be any. The calling thread is worker 0 and
 * returns when all items are done. Worker numbers are below mlrt_worker_count(pool), and a worker runs one item at a
 * time: so data that belong to a worker need no lock.
 */
#ifndef MLRT_BASE_SCHEDULER_H
#define MLRT_BASE_SCHEDULER_H

#include <stdint.h>

#include "mlrt.h"

/* Makes a pool; options and host were checked. Returns a status. */
int32_t mlrt_make_pool(const mlrt_pool_options *options, const mlrt_host *host, mlrt_pool **pool);

/* Ends its threads and frees it. */
void mlrt_end_pool(mlrt_pool *pool);

/* Runs one item. If the result is not 0, no further items start. */
typedef int32_t mlrt_work_function(void *work, uint32_t item, uint32_t worker);

/* How many items of up to `size` elements `count` elements make, and how many elements item `item` of them has. */
static inline uint32_t mlrt_item_count(uint32_t count, uint32_t size)
{
    return count / size + (count % size != 0);
}

static inline uint32_t mlrt_item_size(uint32_t count, uint32_t size, uint32_t item)
{
    return count - item * size < size ? count - item * size : size;
}

/* The number of workers of a pool; 1 for NULL. */
uint32_t mlrt_worker_count(const mlrt_pool *pool);

/*
 * Runs the items on the pool (NULL: all on the calling thread). Returns 0, or the first result of `function` that was
 * not 0. A pool with threads of its own runs one call at a time: others wait.
 */
int32_t mlrt_run_items(mlrt_pool *pool, uint32_t item_count, mlrt_work_function *function, void *work);

#endif
