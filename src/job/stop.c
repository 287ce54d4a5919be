/* SPDX-License-Identifier: MIT */
/*
 * Progress within an item: see stop.h. The host's function runs in the caller's floating-point environment, as it does
 * between items.
 */
#include "job/stop.h"

#include "base/progress.h"

int mlrt_is_stopped(struct mlrt_worker *worker, double pixels)
{
    if (!worker->watch.progress || worker->watch.stopped) return worker->watch.stopped;
    worker->watch.pixels_told += pixels;
    mlrt_leave_fp_environment(&worker->watch.environment);
    const int stopped = mlrt_advance(worker->watch.progress, pixels);
    mlrt_enter_fp_environment(&worker->watch.environment);
    worker->watch.stopped = stopped;
    if (stopped) worker->sinks.count = 0; /* what it finds from now on may be wrong */
    return stopped;
}
