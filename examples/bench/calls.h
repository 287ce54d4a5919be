/* SPDX-License-Identifier: MIT */
/*
 * calls.h - what calls of few rays cost: nanoseconds of mlrt_trace_packet for 1 to 16 rays, over those of as many calls
 * of mlrt_trace_ray, with each option and array, for rays that miss the scene, neighbours in a picture, and rays that
 * have nothing in common; and instructions from call to return (x86-64 Linux). CSV on stdout
 */
#ifndef BENCH_CALLS_H
#define BENCH_CALLS_H

#include "arena.h"

/* Returns 0, or 1 if a call failed. */
int study_calls(const struct bench_settings *settings);

#endif
