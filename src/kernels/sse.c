/* SPDX-License-Identifier: MIT */
/* The kernels in SSE2, for every x86-64 processor. */
#include "simd_sse.h"
#define KERNELS          mlrt_kernels_sse
#define KERNELS_COUNTING mlrt_kernels_sse_counting
#include "kernels_body.h"
