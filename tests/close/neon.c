/* SPDX-License-Identifier: MIT */
#include "simd/neon.h"
#define DECIDE_CLOSE decide_close_neon
#include "body.h"
