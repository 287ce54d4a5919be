/* SPDX-License-Identifier: MIT */
/* The kernels in AVX-512 (F and DQ). Compiled for it (Makefile); dispatch.c sees to it that only processors that have
 * it come here. */
#include "simd/avx512.h"
#define KERNELS mlrt_kernels_avx512
#define PICTURE mlrt_picture_avx512
#include "trace/kernels.h"
