/* SPDX-License-Identifier: MIT */
/*
 * The kernels of the kd-tree in SSE2 that do not count: for packets of 2x2, which have four lanes, and for processors
 * without AVX2.
 */
#include "simd/sse.h"
#define KDTREE_KERNELS mlrt_kernels_kdtree_sse
#include "isa/kernels.h"
