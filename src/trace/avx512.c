/* SPDX-License-Identifier: MIT */
/*
 * The kernels in AVX-512 (F and DQ). The Makefile has the compiler's flags; run/dispatch.c chooses these kernels only
 * on processors that have both. The numbers of one ray's hit need no vectors of eight doubles: AVX2 takes a third less
 * time for them.
 */
#include "simd/avx512.h"
#define KERNELS mlrt_kernels_avx512
#define PICTURE mlrt_picture_avx512
#define REPORTS (&mlrt_kernels_avx2)
#include "trace/kernels.h"
