/* SPDX-License-Identifier: MIT */
/* Runs the work of a call by the workers of its pool: a job, or all hits of rays. */
#ifndef MLRT_RUN_RUN_JOB_H
#define MLRT_RUN_RUN_JOB_H

#include "base/host.h"
#include "job/job.h"

/*
 * Runs a job, whose source, kernels, sinks, method and tile sizes are set. Each item sets the floating-point
 * environment and restores it, so that callbacks run in that of their thread. Returns a status.
 */
int32_t mlrt_run_job(struct mlrt_job *job, const struct mlrt_run_options *options);

/* Writes all hits of the rays of a source, which must not be a camera, to the caller's arrays. Returns a status. */
int32_t mlrt_run_all_hits(const struct mlrt_tree *tree, const struct mlrt_source *source, const mlrt_hit_lists *lists,
                          const struct mlrt_run_options *options);

#endif
