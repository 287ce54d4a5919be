/* SPDX-License-Identifier: MIT */
/* The kernels in plain C, for any processor. */
#include "simd_scalar.h"
#define KERNELS          mlrt_kernels_scalar
#define KERNELS_COUNTING mlrt_kernels_scalar_counting
#define PICTURE          mlrt_plain_picture
#define SHEARED          mlrt_sheared_plain
#define MAKES_SHEARED    !MLRT_COUNTING
#include "bvh_body.h"
