/* SPDX-License-Identifier: MIT */
/* The kernels in AVX2 and FMA. Compiled for them (Makefile); dispatch.c sees to it that only processors that have them
 * come here. */
#include "simd/avx2.h"
#define KERNELS mlrt_kernels_avx2
#define PICTURE mlrt_picture_avx2
#include "trace/kernels.h"
