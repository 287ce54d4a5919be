/* SPDX-License-Identifier: MIT */
/*
 * The exported functions about the library itself: version, capabilities, sizes of structs, texts of status codes, the
 * last message.
 */
#include "base/message.h"
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
        if (mlrt_select_kernels(isa, MLRT_METHOD_TILE, 0))
            capabilities |= (uint64_t)MLRT_CAN_SSE << (isa - MLRT_ISA_SSE);
    }
    return capabilities;
}

MLRT_API void mlrt_struct_sizes(uint32_t *sizes, uint32_t count)
{
    static const uint16_t known[MLRT_STRUCT_COUNT] = {
        [MLRT_STRUCT_HOST] = sizeof(mlrt_host),
        [MLRT_STRUCT_MESH] = sizeof(mlrt_mesh),
        [MLRT_STRUCT_TREE_OPTIONS] = sizeof(mlrt_tree_options),
        [MLRT_STRUCT_TREE_INFO] = sizeof(mlrt_tree_info),
        [MLRT_STRUCT_MEMORY_ESTIMATE] = sizeof(mlrt_memory_estimate),
        [MLRT_STRUCT_LOAD_OPTIONS] = sizeof(mlrt_load_options),
        [MLRT_STRUCT_POOL_OPTIONS] = sizeof(mlrt_pool_options),
        [MLRT_STRUCT_COUNTERS] = sizeof(mlrt_counters),
        [MLRT_STRUCT_TRACE_OPTIONS] = sizeof(mlrt_trace_options),
        [MLRT_STRUCT_ARRAY] = sizeof(mlrt_array),
        [MLRT_STRUCT_HITS] = sizeof(mlrt_hits),
        [MLRT_STRUCT_CONST_ARRAY] = sizeof(mlrt_const_array),
        [MLRT_STRUCT_RAYS] = sizeof(mlrt_rays),
        [MLRT_STRUCT_RAY] = sizeof(mlrt_ray),
        [MLRT_STRUCT_HIT] = sizeof(mlrt_hit),
        [MLRT_STRUCT_HIT_LISTS] = sizeof(mlrt_hit_lists),
        [MLRT_STRUCT_CAMERA] = sizeof(mlrt_camera),
        [MLRT_STRUCT_TILE] = sizeof(mlrt_tile),
        [MLRT_STRUCT_LIGHT] = sizeof(mlrt_light),
        [MLRT_STRUCT_POINTS] = sizeof(mlrt_points),
        [MLRT_STRUCT_KDTREE_OPTIONS] = sizeof(mlrt_kdtree_options),
    };
    for (uint32_t i = 0; sizes && i < count; ++i) sizes[i] = i < MLRT_STRUCT_COUNT ? known[i] : 0;
}
