/* SPDX-License-Identifier: MIT */
/* The kernels of kernels.c once more, for calls with counters. */
#define MLRT_COUNTING 1
#include "base/platform.h"

#if MLRT_HAVE_SSE
#include "simd/sse.h"
#else
#include "simd/scalar.h"
#endif
#define KERNELS mlrt_kernels_kdtree_counting
#define PICTURE mlrt_plain_picture
#include "mlrta/kernels.h"
