/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the kd-tree: four lanes wide where every processor has SSE2, else plain C. They always count, and so
 * serve calls with counters, too; avx2.c has kernels that do not.
 */
#define MLRT_COUNTING 1
#include "base/platform.h"
#if MLRT_SSE_KERNELS
#include "simd/sse.h"
#else
#include "simd/scalar.h"
#endif
#define KERNELS mlrt_kernels_kdtree
#include "mlrta/kernels.h"
