/* SPDX-License-Identifier: MIT */
/* The kernels for the kd-tree: four lanes wide where every processor has SSE2, else plain C. */
#include "base/platform.h"

#if MLRT_HAVE_SSE
#include "simd/sse.h"
#else
#include "simd/scalar.h"
#endif
#define KERNELS mlrt_kernels_kdtree
#define PICTURE mlrt_plain_picture
#include "mlrta/kernels.h"
