/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the hierarchy of boxes, in the words of the simd header that was included before. If its file defines
 * MLRT_COUNTING as 1 before, they count (counters.h). Everything is static but the table.
 */
#ifndef MLRT_TRACE_KERNELS_H
#define MLRT_TRACE_KERNELS_H

#include "job/job.h"
#include "trace/levels.h"
#include "trace/one_ray.h"

const struct mlrt_kernels KERNELS = {.trace_area = trace_area,
                                     .trace_ray = trace_one_ray,
#if VW == 8
                                     .report_ray = report_one_ray
#endif
};

#endif
