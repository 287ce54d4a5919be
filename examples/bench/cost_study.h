/* SPDX-License-Identifier: MIT */
/* cost_study.h - the speed of trees by other costs (bvh/set.h), and by other builds of the library (base/tuning.h) */
#ifndef COST_STUDY_H
#define COST_STUDY_H

#include "arena.h"

/* Trees of one scene take turns. Prints CSV: each tree's rate, and that over the default tree's. Returns 0 or 1. */
int study_costs(const struct bench_settings *settings);

#endif
