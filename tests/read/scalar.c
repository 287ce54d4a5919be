/* SPDX-License-Identifier: MIT */
#include "simd/scalar.h"
#define READERS readers_scalar
#include "body.h"
