/* SPDX-License-Identifier: MIT */
/* timer.h - the time that has passed, and the median of several measurements */
#ifndef TIMER_H
#define TIMER_H

#include <stddef.h>

/* Seconds since a fixed moment, by a clock that cannot be set. */
double seconds_now(void);

/* Seconds that the calling thread has been running for: those in which a busy machine let it wait do not count. */
double thread_seconds_now(void);

/* The value in the middle, or between the two there. Sorts `values`, of which there is at least one. */
double median(double *values, size_t count);

#endif
