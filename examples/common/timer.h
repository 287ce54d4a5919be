/* SPDX-License-Identifier: MIT */
/* timer.h - the time that has passed, and one figure for several measurements */
#ifndef TIMER_H
#define TIMER_H

#include <stddef.h>

/* Seconds since a fixed moment, by a clock that cannot be set. */
double seconds_now(void);

/* Seconds that the calling thread has been running for: those in which a busy machine let it wait do not count. */
double thread_seconds_now(void);

/* The time that passed, and the processor time of all threads of the program. */
struct span {
    double elapsed, processor;
};

/* Both clocks, and how far they have gone since. */
struct span span_start(void);
struct span span_since(struct span start);

/* Sleeps for 5 ms, in which threads of others that were told to end do so. */
void rest(void);

/* The value in the middle, or between the two there. Sorts `values`, of which there is at least one. */
double median(double *values, size_t count);

/* The least of at least one. */
double least(const double *values, size_t count);

#endif
