/* SPDX-License-Identifier: MIT */
/*
 * One ray of a call of its own, in structs of this version, and in the environment of the library. Fields of the hit
 * that the query does not write keep their values.
 */
#ifndef MLRT_RUN_LONE_RAY_H
#define MLRT_RUN_LONE_RAY_H

#include "mlrt.h"
#include "rays/lone_ray.h"

/*
 * Traces a ray through boxes; in double if float does not carry it. The caller has set kernels, mask, `skip` and `any`
 * of *ray, which is used for nothing else afterwards. Returns 1 if it raised no flag of <fenv.h> but inexact, or 0 if it
 * may have.
 */
int mlrt_trace_lone_ray(const mlrt_tree *tree, const mlrt_ray *given, struct mlrt_lone_ray *ray, mlrt_hit *hit);

/*
 * Traces a ray in double, through any structure. `skip` is the number of the triangle that it passes through, or
 * MLRT_NONE. `counters` may be NULL.
 */
void mlrt_trace_by_ray(const mlrt_tree *tree, const mlrt_ray *ray, int any, uint32_t mask, uint32_t skip,
                       mlrt_counters *counters, mlrt_hit *hit);

#endif
