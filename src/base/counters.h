/* SPDX-License-Identifier: MIT */
/*
 * Counting: in kernels that define MLRT_COUNTING as 1 first, COUNT(counters, field, n) adds n to a field of
 * mlrt_counters. In the others it does nothing (run/dispatch.c). COUNTERS(worker) is the pointer to pass to functions
 * of other files: NULL where nothing is counted. CLEAR_COUNTS(worker) sets all counts of a worker to 0.
 */
#ifndef MLRT_BASE_COUNTERS_H
#define MLRT_BASE_COUNTERS_H

#include "mlrt.h"

#if defined(MLRT_COUNTING) && MLRT_COUNTING
#define COUNT(counters, field, n) ((counters)->field += (uint64_t)(n))
#define COUNTERS(worker)          (&(worker)->counters)
#define CLEAR_COUNTS(worker)      ((worker)->counters = (mlrt_counters){0})
#else
#define MLRT_COUNTING             0
#define COUNT(counters, field, n) ((void)(counters), (void)(n))
#define COUNTERS(worker)          ((void)(worker), (mlrt_counters *)NULL)
#define CLEAR_COUNTS(worker)      ((void)(worker))
#endif

#endif
