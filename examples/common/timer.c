/* SPDX-License-Identifier: MIT */
/* timer.c - how much time has passed: see timer.h */
#define _POSIX_C_SOURCE 200112L

#include "timer.h"

#include <time.h>

double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
