/* SPDX-License-Identifier: MIT */
#include "simd/neon.h"
#define READERS readers_neon
#include "body.h"
