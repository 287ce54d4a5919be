/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels. What it can do is asked of the compiler's runtime, which looks once per process,
 * also at whether the operating system saves the wide registers.
 *
 * Who counts gets the kernels in plain C, which do the same work in more steps: one that counts for each instruction
 * set is not worth its size. Where there is SSE nobody is in a hurry with plain C, and it always counts. So do the
 * kernels of the kd-tree.
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
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case MLRT_ISA_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
#endif
    default:
        return 0;
    }
}

const struct mlrt_kernels *mlrt_select_kernels(int32_t isa, int32_t method, int counting)
{
    if (isa == MLRT_ISA_AUTO) {
        isa = MLRT_ISA_AVX512;
        while (!is_supported(isa)) --isa;
    } else if (!is_supported(isa)) {
        return NULL;
    }
    if (method != MLRT_METHOD_TILE) return &mlrt_kernels_kdtree;
    if (counting) return &mlrt_kernels_scalar_counting;
    switch (isa) {
#if MLRT_HAVE_SSE
    case MLRT_ISA_SSE:
        return &mlrt_kernels_sse;
    case MLRT_ISA_AVX2:
        return &mlrt_kernels_avx2;
    case MLRT_ISA_AVX512:
        return &mlrt_kernels_avx512;
    default:
        return &mlrt_kernels_scalar_counting;
#else
    default:
        return &mlrt_kernels_scalar;
#endif
    }
}
