/* SPDX-License-Identifier: MIT */
#include "simd/sse.h"
#define RUN_WORDS run_words_sse
#include "body.h"
