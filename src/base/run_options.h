/* SPDX-License-Identifier: MIT */
/*
 * What a call that traces runs with: threads, counters, and the host.
 */
#ifndef MLRT_BASE_RUN_OPTIONS_H
#define MLRT_BASE_RUN_OPTIONS_H

#include "mlrt.h"

struct mlrt_run_options {
    mlrt_pool *pool;         /* NULL = this thread alone */
    mlrt_counters *counters; /* NULL = nobody counts */
    mlrt_host host;          /* checked; all 0 if there is none */
};

#endif
