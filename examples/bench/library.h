/* SPDX-License-Identifier: MIT */
/* library.h - tasks done by a build of the library */
#ifndef BENCH_LIBRARY_H
#define BENCH_LIBRARY_H

#include "common/loaded_library.h"
#include "task.h"

/* Does a task, and returns the status. */
int32_t run_library(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                    const struct task *task, const struct answers *answers);

#endif
