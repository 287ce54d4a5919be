/* SPDX-License-Identifier: MIT */
#include "simd/avx2.h"
#define RUN_WORDS run_words_avx2
#include "body.h"
