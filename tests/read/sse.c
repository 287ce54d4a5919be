/* SPDX-License-Identifier: MIT */
#include "simd/sse.h"
#define READERS readers_sse
#include "body.h"
