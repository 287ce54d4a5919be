/* SPDX-License-Identifier: MIT */
#include "simd/avx2.h"
#define DECIDE_CLOSE decide_close_avx2
#include "body.h"
