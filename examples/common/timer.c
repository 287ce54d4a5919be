/* SPDX-License-Identifier: MIT */
/* timer.c - times, their median and their least: see timer.h */
#define _POSIX_C_SOURCE 200112L

#include "timer.h"

#include <stdlib.h>
#include <time.h>

static double read_clock(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double seconds_now(void)
{
    return read_clock(CLOCK_MONOTONIC);
}

double thread_seconds_now(void)
{
    return read_clock(CLOCK_THREAD_CPUTIME_ID);
}

struct span span_start(void)
{
    return (struct span){seconds_now(), read_clock(CLOCK_PROCESS_CPUTIME_ID)};
}

struct span span_since(struct span start)
{
    const struct span now = span_start();
    return (struct span){now.elapsed - start.elapsed, now.processor - start.processor};
}

void rest(void)
{
    const struct timespec time = {0, 5000000};
    nanosleep(&time, NULL);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

double least(const double *values, size_t count)
{
    double result = values[0];
    for (size_t i = 1; i < count; i++) {
        if (values[i] < result) result = values[i];
    }
    return result;
}
