/* SPDX-License-Identifier: MIT */
/*
 * The vocabulary of an instruction set: `vf vi vm vd` and their words (scalar.h). It is that of the header of this
 * folder that was included before, or else plain C. A file that includes this is compiled once per instruction set.
 */
#ifndef MLRT_SIMD_SIMD_H
#define MLRT_SIMD_SIMD_H

#ifndef VW
#include "simd/scalar.h"
#endif

#endif
