/* SPDX-License-Identifier: MIT */
/* study.h - speed against the number of triangles or of pixels, and building: CSV on stdout */
#ifndef BENCH_STUDY_H
#define BENCH_STUDY_H

#include "arena.h"

/* The kinds of a study when none are given, as bits. */
uint32_t default_kinds(int32_t study);

/* Returns 0, or 1 after a message on stderr. */
int run_study(const struct bench_settings *settings);

#endif
