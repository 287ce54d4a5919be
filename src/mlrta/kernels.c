/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the kd-tree: four lanes wide where every processor has SSE2, else plain C. They always count, and so
 * serve calls with counters, too; avx2.c has kernels that do not.
 */
#include "base/platform.h"
/*
 * Not before platform.h: there it would end forced inlining, which costs 3 % of the instructions and saves 800 bytes.
 */
#define MLRT_COUNTING 1

#if MLRT_HAVE_SSE
#include "simd/sse.h"
#else
#include "simd/scalar.h"
#endif
#define KERNELS mlrt_kernels_kdtree
#define PICTURE mlrt_plain_picture
#include "mlrta/kernels.h"
