/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the kd-tree, four lanes wide where every processor has them. Wider ones, or more of them, would add a
 * quarter to the library for what the hierarchy of boxes does faster (design.md). They always count, being there for
 * study.
 */
#define MLRT_COUNTING 1
#include "base/platform.h"

#if MLRT_HAVE_SSE
#include "simd/sse.h"
#else
#include "simd/scalar.h"
#endif
#define KERNELS mlrt_kernels_kdtree
#include "mlrta/kernels.h"
