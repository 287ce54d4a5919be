/* SPDX-License-Identifier: MIT */
/*
 * decide_lanes of src/hits/close_calls.h in each instruction set, one object for each. What it leaves to the judge
 * comes to decide_rest, which test_close_calls.c has.
 */
#ifndef CLOSE_H
#define CLOSE_H

#include "job/job.h"

typedef uint32_t decide_function(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                                 struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters);

decide_function decide_close_scalar, decide_close_sse, decide_close_avx2, decide_close_avx512, decide_close_neon;
decide_function decide_rest;

#endif
