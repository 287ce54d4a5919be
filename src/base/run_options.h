/* SPDX-License-Identifier: MIT */
/* The options that all calls that trace have in common: pool, counters and host. */
#ifndef MLRT_BASE_RUN_OPTIONS_H
#define MLRT_BASE_RUN_OPTIONS_H

#include "mlrt.h"

struct mlrt_run_options {
    mlrt_pool *pool;         /* NULL = the calling thread alone */
    mlrt_counters *counters; /* NULL = nothing is counted */
    mlrt_host host;          /* checked; all 0 = no host */
};

#endif
