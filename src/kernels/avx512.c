/* SPDX-License-Identifier: MIT */
/* The kernels in AVX-512 (F and DQ). Compiled for it (Makefile); dispatch.c sees to it that only processors that have
 * it come here. */
#include "simd_avx512.h"
#define KERNELS          mlrt_kernels_avx512
#define KERNELS_COUNTING mlrt_kernels_avx512_counting
#include "kernels_body.h"
