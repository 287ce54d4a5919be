/* SPDX-License-Identifier: MIT */
/*
 * How far a call has come: see progress.h.
 */
#define _POSIX_C_SOURCE 200809L
#include "progress.h"

#include <string.h>
#include <time.h>

/* Hosts are told so often, in seconds: enough to stop within 10 ms, and rare enough for callbacks into Python. */
#define INTERVAL 1e-3

double mlrt_seconds_now(void)
{
    struct timespec now;
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0) return 0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void mlrt_begin_progress(const mlrt_host *host, double total, struct mlrt_progress *progress)
{
    memset(progress, 0, sizeof *progress);
    if (!host->progress) return;
    progress->callback = host->progress;
    progress->user = host->user;
    progress->total = total > 0 ? total : 1;
    pthread_mutex_init(&progress->mutex, NULL);
}

/* With the mutex held. */
static void tell(struct mlrt_progress *progress, double now, double fraction)
{
    progress->told_at = now;
    if (progress->callback(progress->user, fraction) != 0) progress->cancelled = 1;
}

/* An estimate of the total may be too low: then less is told than was done. */
static double fraction_done(const struct mlrt_progress *progress)
{
    const double fraction = progress->done / progress->total;
    return fraction < 0.99 ? fraction : 0.99;
}

int mlrt_advance(struct mlrt_progress *progress, double work)
{
    if (!progress || !progress->callback) return 0;
    pthread_mutex_lock(&progress->mutex);
    progress->done += work;
    const double now = mlrt_seconds_now();
    if (!progress->cancelled && now - progress->told_at >= INTERVAL) tell(progress, now, fraction_done(progress));
    const int32_t cancelled = progress->cancelled;
    pthread_mutex_unlock(&progress->mutex);
    return cancelled != 0;
}

int mlrt_is_cancelled(struct mlrt_progress *progress)
{
    return mlrt_advance(progress, 0);
}

int32_t mlrt_end_progress(struct mlrt_progress *progress, int32_t status)
{
    if (!progress->callback) return status;
    if (status == MLRT_OK) tell(progress, 0, 1);
    pthread_mutex_destroy(&progress->mutex);
    return status;
}
