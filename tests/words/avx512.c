/* SPDX-License-Identifier: MIT */
#include "simd/avx512.h"
#define RUN_WORDS run_words_avx512
#include "body.h"
