/* SPDX-License-Identifier: MIT */
#include "simd/neon.h"
#define RUN_WORDS run_words_neon
#include "body.h"
