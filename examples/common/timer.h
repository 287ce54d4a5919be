/* SPDX-License-Identifier: MIT */
/* timer.h - how much time has passed */
#ifndef TIMER_H
#define TIMER_H

/* Seconds since some fixed moment, by a clock that nobody sets. */
double seconds_now(void);

#endif
