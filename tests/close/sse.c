/* SPDX-License-Identifier: MIT */
#include "simd/sse.h"
#define DECIDE_CLOSE decide_close_sse
#include "body.h"
