/* SPDX-License-Identifier: MIT */
/* Reports progress to the host in the middle of an item, and asks whether the host has ended the call. */
#ifndef MLRT_JOB_STOP_H
#define MLRT_JOB_STOP_H

#include "job/job.h"

/*
 * Adds pixels that are done, and calls the host if it was not called for a millisecond (base/progress.h). Returns 1 if
 * the call is to end: from then on the worker's results are not written, and may be wrong. To be called in the
 * floating-point environment of the library.
 */
int mlrt_is_stopped(struct mlrt_worker *worker, double pixels);

/* Steps that take up to some microseconds ask the host in one of so many calls only. */
#define MLRT_SLOW_STEPS 64

/* As mlrt_is_stopped, for such a step, with no pixels done. */
static inline int mlrt_is_stopped_in_step(struct mlrt_worker *worker)
{
    if (!worker->watch.progress) return 0;
    if (++worker->watch.slow_steps % MLRT_SLOW_STEPS == 0) return mlrt_is_stopped(worker, 0);
    return worker->watch.stopped;
}

#endif
