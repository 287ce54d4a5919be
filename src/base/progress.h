/* SPDX-License-Identifier: MIT */
/*
 * Progress of a call: the fraction done is told to the host, from any of the call's threads, and the host's answer may
 * cancel the call.
 */
#ifndef MLRT_BASE_PROGRESS_H
#define MLRT_BASE_PROGRESS_H

#include <pthread.h>

#include "mlrt.h"

/* All 0 = the host has no progress function. Guarded by its mutex. */
struct mlrt_progress {
    mlrt_progress_callback callback;
    void *user;
    pthread_mutex_t mutex;
    double total; /* work of the whole call, in any unit: an estimate */
    double done;
    double told_at;    /* seconds: when the host was last called */
    int32_t cancelled; /* 1 = the call is to end */
    int32_t telling;   /* 1 = a thread is calling the host now */
};

/* Seconds of a clock that never runs backwards, from an arbitrary start. */
double mlrt_seconds_now(void);

/* Sets *progress for a call whose work will be about `total`. */
void mlrt_begin_progress(const mlrt_host *host, double total, struct mlrt_progress *progress);

/*
 * Adds work done, and calls the host if it has not been called for a millisecond. Returns 1 if the call is cancelled:
 * then the caller returns as soon as it can, with its results unfinished, and only frees its memory. From any thread;
 * `progress` may be NULL.
 */
int mlrt_advance(struct mlrt_progress *progress, double work);

/* As mlrt_advance, with no work done. */
int mlrt_is_cancelled(struct mlrt_progress *progress);

/* Loops over large arrays ask once in so many rounds whether the call is cancelled. */
#define MLRT_ROUNDS 8192

static inline int mlrt_is_cancelled_in_round(struct mlrt_progress *progress, size_t round)
{
    return round % MLRT_ROUNDS == 0 && mlrt_is_cancelled(progress);
}

/* Tells the host that all is done, if the call's `status` is MLRT_OK. Returns `status`. */
int32_t mlrt_end_progress(struct mlrt_progress *progress, int32_t status);

#endif
