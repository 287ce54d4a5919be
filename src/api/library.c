/* SPDX-License-Identifier: MIT */
/*
 * The exported functions about the library itself: version, capabilities, sizes of structs, texts of status codes, the
 * last message.
 */
#include "base/forms.h"
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
    for (int32_t isa = MLRT_ISA_SSE; isa <= MLRT_ISA_NEON; ++isa) {
        if (mlrt_select_kernels(&mlrt_structure_bvh, isa, MLRT_METHOD_TILE, 0))
            capabilities |= (uint64_t)MLRT_CAN_SSE << (isa - MLRT_ISA_SSE);
    }
    return capabilities;
}

MLRT_API void mlrt_struct_sizes(uint32_t *sizes, uint32_t count)
{
    for (uint32_t i = 0; sizes && i < count; ++i) sizes[i] = i < MLRT_STRUCT_COUNT ? mlrt_forms[i].own_size : 0;
}
