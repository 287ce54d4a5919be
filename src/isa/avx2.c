/* SPDX-License-Identifier: MIT */
/*
 * The kernels in AVX2 and FMA. The Makefile has the compiler's flags; run/dispatch.c chooses these kernels only on
 * processors that have both.
 */
#include "simd/avx2.h"
#define BOX_KERNELS    mlrt_kernels_avx2
#define KDTREE_KERNELS mlrt_kernels_kdtree_avx2
#include "isa/kernels.h"
