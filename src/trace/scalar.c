/* SPDX-License-Identifier: MIT */
/* The kernels in plain C, for any processor. */
#include "simd/scalar.h"
#define KERNELS          mlrt_kernels_scalar
#define KERNELS_COUNTING mlrt_kernels_scalar_counting
#define PICTURE          mlrt_plain_picture
#include "trace/kernels.h"
