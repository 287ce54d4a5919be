/* SPDX-License-Identifier: MIT */
/* Runs a job: its tiles, workers and counters. */
#ifndef MLRT_RUN_RUN_JOB_H
#define MLRT_RUN_RUN_JOB_H

#include "base/host.h"
#include "job/job.h"

/*
 * Runs a job, whose source, kernels, sinks, method and tile sizes are set. Each item sets the floating-point
 * environment and restores it, so that callbacks run in that of their thread. Returns a status.
 */
int32_t mlrt_run_job(struct mlrt_job *job, const struct mlrt_run_options *options);

#endif
