/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the kd-tree in AVX2 and FMA: half a packet in a vector. The Makefile has the compiler's flags;
 * run/dispatch.c chooses these kernels only on processors that have both, for calls without counters.
 */
#include "simd/avx2.h"
#define KERNELS mlrt_kernels_kdtree_avx2
#include "mlrta/kernels.h"
