/* SPDX-License-Identifier: MIT */
#include "simd/scalar.h"
#define RUN_WORDS run_words_scalar
#include "body.h"
