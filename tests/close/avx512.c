/* SPDX-License-Identifier: MIT */
#include "simd/avx512.h"
#define DECIDE_CLOSE decide_close_avx512
#include "body.h"
