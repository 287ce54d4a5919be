/* SPDX-License-Identifier: MIT */
#include "simd/avx512.h"
#define READERS readers_avx512
#include "body.h"
