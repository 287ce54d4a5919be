/* SPDX-License-Identifier: MIT */
/*
 * From a job to its results: tiles, workers, counters.
 */
#ifndef MLRT_RUN_WORKERS_H
#define MLRT_RUN_WORKERS_H

#include "base/run_options.h"
#include "job/job.h"

/*
 * Runs a job. Its source, sinks, method and tile sizes are set; without counters job->kernels do not count. Each item
 * sets and restores the floating-point environment for itself, so that callbacks run in their thread's own. Returns a
 * status.
 */
int32_t mlrt_run_job(const struct mlrt_job *job, const struct mlrt_run_options *options);

#endif
