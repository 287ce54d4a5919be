/* SPDX-License-Identifier: MIT */
/* The kernels in plain C, for processors without SSE2 and NEON. They count. */
#define MLRT_COUNTING 1
#include "simd/scalar.h"
#define BOX_KERNELS    mlrt_kernels_scalar
#define KDTREE_KERNELS mlrt_kernels_kdtree_scalar
#include "isa/kernels.h"
