/* SPDX-License-Identifier: MIT */
#include "kernels/simd_avx2.h"
#define DECIDE_CLOSE decide_close_avx2
#include "body.h"
