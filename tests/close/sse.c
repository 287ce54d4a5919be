/* SPDX-License-Identifier: MIT */
#include "kernels/simd_sse.h"
#define DECIDE_CLOSE decide_close_sse
#include "body.h"
