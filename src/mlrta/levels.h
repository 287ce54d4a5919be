/* SPDX-License-Identifier: MIT */
/*
 * The levels of the multi-level method: tiles, their pieces, and packets. levels.c explains them.
 */
#ifndef MLRT_MLRTA_LEVELS_H
#define MLRT_MLRTA_LEVELS_H

#include "job/job.h"

/* trace_tile (job/job.h) of all kernels of the kd-tree; packets go to their trace_block. It always counts. */
void mlrt_trace_kdtree_tile(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile);

#endif
