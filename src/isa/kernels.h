/* SPDX-License-Identifier: MIT */
/*
 * The kernels of an instruction set, in the words of the simd header that the unit includes before this one. If the
 * unit defines MLRT_COUNTING as 1 first, the kernels count (counters.h). BOX_KERNELS and KDTREE_KERNELS are the names
 * of the tables of the two structures; a structure whose name is not defined is not compiled. Both structures are in
 * one unit, since they share the functions of hits/ and rays/. Everything is static but the tables.
 */
#ifndef MLRT_ISA_KERNELS_H
#define MLRT_ISA_KERNELS_H

#include "hits/blocks.h"
#include "hits/close_calls.h"
#include "job/job.h"
#include "rays/extremes.h"
#include "simd/simd.h"

#ifdef BOX_KERNELS
#include "trace/levels.h"
#include "trace/lone_ray.h"

const struct mlrt_kernels BOX_KERNELS = {.width = VW, .trace_area = trace_area, .trace_ray = trace_lone_ray};
#endif

#ifdef KDTREE_KERNELS
#include "mlrta/levels.h"

const struct mlrt_kernels KDTREE_KERNELS = {.width = VW, .trace_area = trace_kdtree_area};
#endif

#endif
