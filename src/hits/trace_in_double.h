/* SPDX-License-Identifier: MIT */
/* Rays of a packet that float does not carry, traced one by one in double. Compiled once for all instruction sets. */
#ifndef MLRT_HITS_TRACE_IN_DOUBLE_H
#define MLRT_HITS_TRACE_IN_DOUBLE_H

#include "job/job.h"

/*
 * Traces lanes of a packet, and stores the triangles that they hit; none if the call is to end. `counters` may be NULL.
 */
void mlrt_trace_in_double(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                          struct mlrt_worker *worker, mlrt_counters *counters);

#endif
