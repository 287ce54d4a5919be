/* SPDX-License-Identifier: MIT */
/*
 * One ray through the tree, the textbook way: what every other path must match.
 */
#ifndef MLRT_RUN_TRACE_RAY_H
#define MLRT_RUN_TRACE_RAY_H

#include "exact/hit_list.h"

/*
 * The number of the nearest triangle hit, or MLRT_NONE; with `any`, of some triangle hit. `skip` is the number of a
 * triangle that does not count (MLRT_NONE: all do). `counters` may be NULL. Any finite numbers are right here.
 */
uint32_t mlrt_trace_segment(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                            mlrt_counters *counters);

/* All hits, in place of what the list held, each once and in no particular order; list->failed says if one is missing.
 */
void mlrt_gather_hits(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip,
                      struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
