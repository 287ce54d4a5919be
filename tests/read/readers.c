/* SPDX-License-Identifier: MIT */
/*
 * Which readers this machine can run. The words of plain C run on all.
 */
#include "read.h"
#include "../support.h"

const struct readers *readers_of(int32_t isa)
{
    if (isa == MLRT_ISA_SCALAR) return &readers_scalar;
#if MLRT_SSE_KERNELS
    static const struct readers *const others[] = {&readers_sse, &readers_avx2, &readers_avx512};
    if (isa_is_supported(isa)) return others[isa - MLRT_ISA_SSE];
#elif MLRT_NEON_KERNELS
    if (isa == MLRT_ISA_NEON) return &readers_neon;
#endif
    return NULL;
}
