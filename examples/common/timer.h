/* SPDX-License-Identifier: MIT */
/* timer.h - how much time has passed, and what of several measurements to report */
#ifndef TIMER_H
#define TIMER_H

#include <stddef.h>

/* Seconds since some fixed moment, by a clock that nobody sets. */
double seconds_now(void);

/* Seconds that the calling thread has been running for: those in which a busy machine let it wait do not count. */
double thread_seconds_now(void);

/* The value in the middle, or between the two there. Sorts `values`, of which there is at least one. */
double median(double *values, size_t count);

#endif
