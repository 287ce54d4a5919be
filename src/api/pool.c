/* SPDX-License-Identifier: MIT */
/*
 * The exported functions for pools of threads.
 */
#include "base/message.h"
#include "base/scheduler.h"
#include "base/structs.h"
#include "mlrt.h"

MLRT_API int32_t mlrt_create_pool_with_options(const mlrt_pool_options *options, mlrt_pool **pool)
{
    if (!pool) return mlrt_note_status(MLRT_ERROR_ARGUMENT);
    *pool = NULL;
    if (!options) return mlrt_note_status(MLRT_ERROR_ARGUMENT);
    mlrt_pool_options own;
    const int32_t status = mlrt_take_struct(options, MLRT_SIZE_UP_TO(mlrt_pool_options, finish), &own, sizeof own);
    return mlrt_note_status(status == MLRT_OK ? mlrt_make_pool(&own, pool) : status);
}

MLRT_API int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool)
{
    const mlrt_pool_options options = {.struct_size = sizeof options, .thread_count = thread_count};
    return mlrt_note_status(mlrt_create_pool_with_options(&options, pool));
}

MLRT_API void mlrt_destroy_pool(mlrt_pool *pool)
{
    if (pool) mlrt_end_pool(pool);
}
