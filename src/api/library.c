/* SPDX-License-Identifier: MIT */
/*
 * The exported functions about the library itself: version, capabilities, sizes of structs, texts of status codes, the
 * last message; and those for pools of threads.
 */
#include "base/host.h"
#include "base/scheduler.h"
#include "base/structs.h"
#include "mlrt.h"
#include "run/dispatch.h"

MLRT_API uint32_t mlrt_version(void)
{
    return MLRT_VERSION_MAJOR * 10000 + MLRT_VERSION_MINOR * 100 + MLRT_VERSION_PATCH;
}

MLRT_API const char *mlrt_status_string(int32_t status)
{
    return mlrt_meaning_of(status);
}

MLRT_API const char *mlrt_last_message(void)
{
    return mlrt_message_of_thread();
}

MLRT_API uint64_t mlrt_capabilities(void)
{
    uint64_t capabilities = 0;
    for (int32_t isa = MLRT_ISA_SSE; isa <= MLRT_ISA_AVX512; ++isa) {
        if (mlrt_select_kernels(&mlrt_structure_bvh, isa, MLRT_METHOD_TILE, 0))
            capabilities |= (uint64_t)MLRT_CAN_SSE << (isa - MLRT_ISA_SSE);
    }
    return capabilities;
}

MLRT_API void mlrt_struct_sizes(uint32_t *sizes, uint32_t count)
{
    for (uint32_t i = 0; sizes && i < count; ++i) sizes[i] = i < MLRT_STRUCT_COUNT ? mlrt_forms[i].own_size : 0;
}

/* ---- pools of threads ---- */

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

MLRT_API void mlrt_destroy_pool(mlrt_pool *pool)
{
    if (pool) mlrt_end_pool(pool);
}
