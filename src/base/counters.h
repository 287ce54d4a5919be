/* SPDX-License-Identifier: MIT */
/*
 * Counting: in object files compiled with MLRT_COUNTING=1, COUNT(counters, field, n) adds n to a field of
 * mlrt_counters. In the others it does nothing, so calls without counters pay nothing for it (dispatch.c).
 * COUNTERS(worker) is the pointer to pass to functions of other files: NULL where nothing is counted.
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

/* Adds every count of *from to *to, as far as to->struct_size reaches. */
void mlrt_add_counters(mlrt_counters *to, const mlrt_counters *from);

#endif
