/* SPDX-License-Identifier: MIT */
#include "kernels/simd_scalar.h"
#define RUN_WORDS run_words_scalar
#include "body.h"
