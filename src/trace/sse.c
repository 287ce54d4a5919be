/* SPDX-License-Identifier: MIT */
/* The kernels in SSE2, for every x86-64 processor. They count. */
#define MLRT_COUNTING 1
#include "simd/sse.h"
#define KERNELS mlrt_kernels_sse
#include "trace/kernels.h"
