/* SPDX-License-Identifier: MIT */
#include "kernels/simd_scalar.h"
#define DECIDE_CLOSE decide_close_scalar
#include "body.h"
