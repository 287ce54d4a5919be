/* SPDX-License-Identifier: MIT */
/*
 * Shares out numbered work items among the threads of a pool. It knows nothing of rays.
 *
 * Every item 0..item_count - 1 is run exactly once, each by one worker; which one is not determined. The caller is
 * worker 0 and blocks until all are done. Workers are numbered below mlrt_worker_count(pool), and no two items run at
 * the same time with the same worker number: so data per worker needs no lock.
 */
#ifndef MLRT_BASE_SCHEDULER_H
#define MLRT_BASE_SCHEDULER_H

#include <stdint.h>

#include "mlrt.h"

/* Makes a pool; the options are of this version. Returns a status. */
int32_t mlrt_make_pool(const mlrt_pool_options *options, mlrt_pool **pool);

/* Ends its threads and frees it. */
void mlrt_end_pool(mlrt_pool *pool);

/* Runs one item. Anything but 0 stops the claiming of further items. */
typedef int32_t mlrt_work_function(void *work, uint32_t item, uint32_t worker);

/* Workers of a pool; 1 for NULL. */
uint32_t mlrt_worker_count(const mlrt_pool *pool);

/*
 * Runs the items on the pool (NULL: all on the calling thread). Returns 0, or what the function first returned that was
 * not 0. Calls that share a pool wait for each other.
 */
int32_t mlrt_run_items(mlrt_pool *pool, uint32_t item_count, mlrt_work_function *function, void *work);

#endif
