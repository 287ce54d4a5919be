/* SPDX-License-Identifier: MIT */
/*
 * How far a call has come, told to the host from whichever of its threads is there, and whether it is to go on.
 */
#ifndef MLRT_BASE_PROGRESS_H
#define MLRT_BASE_PROGRESS_H

#include <pthread.h>

#include "mlrt.h"

/* All 0 = nobody wants to know. Guarded by its mutex. */
struct mlrt_progress {
    mlrt_progress_callback callback;
    void *user;
    pthread_mutex_t mutex;
    double total; /* of any unit of work; an estimate will do */
    double done;
    double told_at; /* seconds */
    int32_t cancelled;
    int32_t telling; /* somebody tells the host just now */
};

/* Seconds since some time. */
double mlrt_seconds_now(void);

void mlrt_begin_progress(const mlrt_host *host, double total, struct mlrt_progress *progress);

/*
 * Adds work done, and tells the host if it was last told some time ago. Returns 1 if the call is to end: then it does,
 * whatever state things are in, but for what has to be freed. From any thread; NULL is allowed.
 */
int mlrt_advance(struct mlrt_progress *progress, double work);

/* Likewise, with nothing done. */
int mlrt_is_cancelled(struct mlrt_progress *progress);

/* For loops over large arrays: in every so many rounds, looks whether the call is to end. */
#define MLRT_ROUNDS 8192

static inline int mlrt_is_cancelled_in_round(struct mlrt_progress *progress, size_t round)
{
    return round % MLRT_ROUNDS == 0 && mlrt_is_cancelled(progress);
}

/* Tells the host that all is done, if it is: `status` is that of the call. Returns it. */
int32_t mlrt_end_progress(struct mlrt_progress *progress, int32_t status);

/* Likewise, of a call that has nothing to do. Returns MLRT_OK. */
int32_t mlrt_end_nothing(const mlrt_host *host);

#endif
