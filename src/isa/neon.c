/* SPDX-License-Identifier: MIT */
/* The kernels in NEON, which every aarch64 processor has. They count. */
#define MLRT_COUNTING 1
#include "simd/neon.h"
#define BOX_KERNELS    mlrt_kernels_neon
#define KDTREE_KERNELS mlrt_kernels_kdtree_neon
#include "isa/kernels.h"
