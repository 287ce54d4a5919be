/* SPDX-License-Identifier: MIT */
/*
 * A worker looks up in the middle of an item: the host is told how far the call has come, and may end it.
 */
#ifndef MLRT_JOB_STOP_H
#define MLRT_JOB_STOP_H

#include "job/job.h"

/*
 * Adds pixels that are done, and tells the host if it was last told some time ago (progress.h). Returns 1 if the call
 * is to end: from then on the worker's results are not looked at, and what it has begun may end as it likes. Called in
 * the floating-point environment of the library.
 */
int mlrt_is_stopped(struct mlrt_worker *worker, double pixels);

/* Likewise, in a step of up to some microseconds, with nothing done: looks up in one of so many only. */
#define MLRT_SLOW_STEPS 64

static inline int mlrt_is_stopped_in_step(struct mlrt_worker *worker)
{
    if (!worker->progress) return 0;
    if (++worker->slow_steps % MLRT_SLOW_STEPS == 0) return mlrt_is_stopped(worker, 0);
    return worker->stopped;
}

#endif
