/* SPDX-License-Identifier: MIT */
/*
 * The kernels of an instruction set, in the words of the simd header that was included before. If its file defines
 * MLRT_COUNTING as 1 before, they count (counters.h). Both structures are in one unit, since they share the functions of
 * hits/ and rays/. Everything is static but the tables.
 */
#ifndef MLRT_ISA_KERNELS_H
#define MLRT_ISA_KERNELS_H

#include "job/job.h"
#include "simd/simd.h"
#include "trace/levels.h"
#include "trace/one_ray.h"

const struct mlrt_kernels BOX_KERNELS = {.trace_area = trace_area,
                                         .trace_ray = trace_one_ray,
#if VW == 8
                                         .report_ray = report_one_ray
#endif
};

/* Sixteen lanes are no faster for a kd-tree than eight. */
#if VW <= 8
#include "mlrta/levels.h"

const struct mlrt_kernels KDTREE_KERNELS = {.trace_area = trace_kdtree_area};
#endif

#endif
