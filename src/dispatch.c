/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels. Everything so far is in the base instruction set of its architecture, so nothing
 * has to be asked of the processor.
 */
#include "dispatch.h"

const struct mlrt_kernels *mlrt_select_kernels(int32_t isa, int counting)
{
    switch (isa) {
    case MLRT_ISA_SCALAR:
        return counting ? &mlrt_kernels_scalar_counting : &mlrt_kernels_scalar;
#if MLRT_HAVE_SSE
    case MLRT_ISA_AUTO:
    case MLRT_ISA_SSE:
        return counting ? &mlrt_kernels_sse_counting : &mlrt_kernels_sse;
#else
    case MLRT_ISA_AUTO:
        return counting ? &mlrt_kernels_scalar_counting : &mlrt_kernels_scalar;
#endif
    default:
        return NULL;
    }
}
