/* SPDX-License-Identifier: MIT */
/*
 * Counting: COUNT(counters, field, n) adds n to a field of mlrt_counters in the object files compiled with
 * MLRT_COUNTING=1, and is nothing in the others, so that nobody pays who does not ask (dispatch.c). COUNTERS(worker) is
 * what functions of other files are handed: NULL where nothing is counted.
 */
#ifndef MLRT_BASE_COUNTERS_H
#define MLRT_BASE_COUNTERS_H

#include "mlrt.h"

#if defined(MLRT_COUNTING) && MLRT_COUNTING
#define COUNT(counters, field, n) ((counters)->field += (uint64_t)(n))
#define COUNTERS(worker)          (&(worker)->counters)
#else
#define MLRT_COUNTING             0
#define COUNT(counters, field, n) ((void)(counters))
#define COUNTERS(worker)          NULL
#endif

/* Adds every count of *from to *to. */
void mlrt_add_counters(mlrt_counters *to, const mlrt_counters *from);

#endif
