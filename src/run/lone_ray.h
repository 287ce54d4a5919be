/* SPDX-License-Identifier: MIT */
/*
 * Rays one by one, of calls of one ray or of a few, in the floating-point environment of the library. Fields of a hit
 * that the query does not write keep their values.
 */
#ifndef MLRT_RUN_LONE_RAY_H
#define MLRT_RUN_LONE_RAY_H

#include "mlrt.h"
#include "rays/lone_ray.h"

/*
 * Traces a ray through boxes; in double if float does not carry it. The caller has set its numbers as given, and
 * kernels, mask, `skip` and `any`, which are left as they are.
 */
void mlrt_trace_lone_ray(const mlrt_tree *tree, struct mlrt_lone_ray *ray, mlrt_hit *hit);

/* Traces a ray in double, through any structure. `counters` may be NULL. */
void mlrt_trace_by_ray(const mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_counters *counters, mlrt_hit *hit);

/* job/job.h, base/host.h */
struct mlrt_job;
struct mlrt_run_options;

/*
 * Traces the rays of a job, in any floating-point environment, one by one through boxes, without a worker, and writes
 * the results to the arrays of a list. Returns 0, and does nothing, if it is faster to trace them together, or if a
 * worker is needed: for another method, for counters, or for a host that watches progress and may end the call. Of the
 * job, the frame and what options say of tiles is not used. All rays are read before a result is written, so results
 * may lie on rays, which mlrt.h does not promise.
 */
int mlrt_trace_few_rays(const struct mlrt_job *job, const struct mlrt_run_options *options, const mlrt_hits *list);

#endif
