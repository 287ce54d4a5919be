/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels. What it can do is asked of the compiler's runtime, which looks once per process,
 * also at whether the operating system saves the wide registers.
 *
 * Who counts gets the kernels of four lanes (without SSE of one): others do the same work in fewer or more steps, and
 * are not worth their size twice. Nor are wide kernels for the kd-tree (kernels_body.h).
 */
#include "dispatch.h"

static int is_supported(int32_t isa)
{
    switch (isa) {
    case MLRT_ISA_SCALAR:
        return 1;
#if MLRT_HAVE_SSE
    case MLRT_ISA_SSE:
        return 1;
    case MLRT_ISA_AVX2:
        return __builtin_cpu_supports("avx2");
    case MLRT_ISA_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
#endif
    default:
        return 0;
    }
}

/* The instruction set of the kernels that take the place of what was asked for. */
static int32_t narrow_isa(int32_t isa, int32_t method, int counting)
{
    if (!counting && method == MLRT_METHOD_TILE) return isa;
    return MLRT_HAVE_SSE ? MLRT_ISA_SSE : MLRT_ISA_SCALAR;
}

const struct mlrt_kernels *mlrt_select_kernels(int32_t isa, int32_t method, int counting)
{
    if (isa == MLRT_ISA_AUTO) {
        isa = MLRT_ISA_AVX512;
        while (!is_supported(isa)) --isa;
    } else if (!is_supported(isa)) {
        return NULL;
    }
    switch (narrow_isa(isa, method, counting)) {
#if MLRT_HAVE_SSE
    case MLRT_ISA_SSE:
        return counting ? &mlrt_kernels_sse_counting : &mlrt_kernels_sse;
    case MLRT_ISA_AVX2:
        return &mlrt_kernels_avx2;
    case MLRT_ISA_AVX512:
        return &mlrt_kernels_avx512;
#endif
    default:
#if !MLRT_HAVE_SSE
        if (counting) return &mlrt_kernels_scalar_counting;
#endif
        return &mlrt_kernels_scalar;
    }
}
