/* SPDX-License-Identifier: MIT */
#include "simd/scalar.h"
#define DECIDE_CLOSE decide_close_scalar
#include "body.h"
