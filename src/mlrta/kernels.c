/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the kd-tree: four lanes wide where every processor has SSE2, else plain C. They exist once, since a
 * set for each instruction set would add a quarter to the library, and the hierarchy of boxes is faster
 * (docs/design.md). They always count, since they are there for study.
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
