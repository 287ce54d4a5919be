/* SPDX-License-Identifier: MIT */
/* The exported functions for pools of threads. */
#include "base/host.h"
#include "base/scheduler.h"
#include "base/structs.h"
#include "mlrt.h"

/* `path` names the options. */
static int32_t create_pool(const char *path, const mlrt_pool_options *options, mlrt_pool **pool)
{
    if (pool) *pool = NULL;
    if (!options || !pool) return mlrt_fail_null("options pool", !options);
    mlrt_pool_options own;
    struct mlrt_voice voice = {.message = NULL};
    int32_t status = mlrt_take_struct(MLRT_STRUCT_POOL_OPTIONS, path, 0, options, &own);
    if (status == MLRT_OK) status = mlrt_take_host("options.host", own.host, &voice.host);
    if (status == MLRT_OK && !own.enqueue != !own.finish) {
        status = mlrt_fail(MLRT_ERROR_ARGUMENT, "options.%s",
                           own.finish ? "finish: given, but enqueue is NULL" : "finish: NULL, but enqueue is given");
    }
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_make_pool(&own, &voice.host, pool));
    return mlrt_end_call(&voice, status);
}

MLRT_API int32_t mlrt_create_pool_with_options(const mlrt_pool_options *options, mlrt_pool **pool)
{
    return create_pool("options", options, pool);
}

MLRT_API int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool)
{
    const mlrt_pool_options options = {.struct_size = sizeof options, .thread_count = thread_count};
    return create_pool("", &options, pool);
}

MLRT_API uint32_t mlrt_pool_thread_count(const mlrt_pool *pool)
{
    return mlrt_worker_count(pool);
}

MLRT_API void mlrt_destroy_pool(mlrt_pool *pool)
{
    if (pool) mlrt_end_pool(pool);
}
