/* SPDX-License-Identifier: MIT */
/* Progress and cancelling: see progress.h. */
#define _POSIX_C_SOURCE 200809L
#include "base/progress.h"

#include <string.h>
#include <time.h>

#include "base/platform.h"

/* Least time in seconds between two calls of the host: short enough to stop within 10 ms, long enough for Python. */
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

/* Adds work, with the mutex held. Returns 1 if it is time to call the host, with the *fraction to tell it. */
static MLRT_NOINLINE int is_time_to_tell(struct mlrt_progress *progress, double work, double *fraction)
{
    progress->done += work;
    const double now = mlrt_seconds_now();
    if (progress->cancelled || progress->telling || now - progress->told_at < INTERVAL) return 0;
    /* The total is an estimate and may be too low; 1 is told at the end only (mlrt_end_progress). */
    *fraction = progress->done / progress->total;
    if (*fraction > 0.99) *fraction = 0.99;
    progress->told_at = now;
    progress->telling = 1;
    return 1;
}

/*
 * The host is called without the mutex, because its function may wait for tasks and run tasks of this same call. The
 * work is added in the library's floating-point environment, since callers may be in their own.
 */
int mlrt_advance(struct mlrt_progress *progress, double work)
{
    double fraction;
    if (!progress || !progress->callback) return 0;
    pthread_mutex_lock(&progress->mutex);
    int tells;
    MLRT_COMPUTE(tells = is_time_to_tell(progress, work, &fraction));
    if (tells) {
        pthread_mutex_unlock(&progress->mutex);
        const int32_t answer = progress->callback(progress->user, fraction);
        pthread_mutex_lock(&progress->mutex);
        progress->telling = 0;
        if (answer != 0) progress->cancelled = 1;
    }
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
    if (status == MLRT_OK) (void)progress->callback(progress->user, 1);
    pthread_mutex_destroy(&progress->mutex);
    return status;
}
