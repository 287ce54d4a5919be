/* SPDX-License-Identifier: MIT */
/* The kernels in plain C, for processors without SSE2. They count. */
#define MLRT_COUNTING 1
#include "simd/scalar.h"
#define KERNELS mlrt_kernels_scalar
#include "trace/kernels.h"
