/* SPDX-License-Identifier: MIT */
#include "kernels/simd_sse.h"
#define RUN_WORDS run_words_sse
#include "body.h"
