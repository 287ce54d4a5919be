/* SPDX-License-Identifier: MIT */
/*
 * The kernels for the kd-tree, in the words of the simd header that was included before. Everything is static but the
 * table.
 */
#ifndef MLRT_MLRTA_KERNELS_H
#define MLRT_MLRTA_KERNELS_H

#include "job/job.h"
#include "mlrta/levels.h"

const struct mlrt_kernels KERNELS = {.trace_area = trace_kdtree_area};

#endif
