/* SPDX-License-Identifier: MIT */
/* The kernels in SSE2, for every x86-64 processor. */
#include "simd_sse.h"
#define KERNELS mlrt_kernels_sse
#define PICTURE mlrt_plain_picture
#include "bvh_body.h"
