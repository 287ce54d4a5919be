/* SPDX-License-Identifier: MIT */
/*
 * Vectors of four floats for code that is compiled once: in the instruction set that every processor of this kind has.
 */
#ifndef MLRT_QUAD_H
#define MLRT_QUAD_H

#include "base/platform.h"

#if MLRT_SSE_KERNELS
#include "simd/quad_sse.h"
#elif MLRT_NEON_KERNELS
#include "simd/quad_neon.h"
#else
#include "simd/quad_scalar.h"
#endif

#endif
