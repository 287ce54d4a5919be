/* SPDX-License-Identifier: MIT */
/*
 * The kernels in SSE2, for every x86-64 processor. They count, and serve calls with counters on wider processors, too.
 */
#define MLRT_COUNTING 1
#include "simd/sse.h"
#define BOX_KERNELS    mlrt_kernels_sse
#define KDTREE_KERNELS mlrt_kernels_kdtree_sse
#include "isa/kernels.h"
