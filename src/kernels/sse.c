/* SPDX-License-Identifier: MIT */
/* The kernels in SSE2, for every x86-64 processor. */
#include "simd_sse.h"
#define KERNELS       mlrt_kernels_sse
#define PICTURE       mlrt_plain_picture
#define SHEARED       mlrt_sheared_plain
#define MAKES_SHEARED 1
#include "bvh_body.h"
