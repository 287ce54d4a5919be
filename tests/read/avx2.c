/* SPDX-License-Identifier: MIT */
#include "simd/avx2.h"
#define READERS readers_avx2
#include "body.h"
