/* SPDX-License-Identifier: MIT */
/*
 * The kernels in AVX-512 (F and DQ). The Makefile has the compiler's flags; run/dispatch.c chooses these kernels only
 * on processors that have both.
 */
#include "simd/avx512.h"
#define KERNELS mlrt_kernels_avx512
#include "trace/kernels.h"
