/* SPDX-License-Identifier: MIT */
/*
 * The kernels in AVX-512 (F and DQ), of boxes alone: for a kd-tree, sixteen lanes are no faster than eight. The
 * Makefile has the compiler's flags; run/dispatch.c chooses these kernels only on processors that have both extensions.
 */
#include "simd/avx512.h"
#define BOX_KERNELS mlrt_kernels_avx512
#include "isa/kernels.h"
