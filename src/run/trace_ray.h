/* SPDX-License-Identifier: MIT */
/*
 * One ray through a tree, the textbook way: the answers that every other path must match.
 */
#ifndef MLRT_RUN_TRACE_RAY_H
#define MLRT_RUN_TRACE_RAY_H

#include "exact/hit_list.h"

/*
 * Returns the number of the triangle of the nearest hit, or MLRT_NONE; with `any`, of any hit. `skip` is the number of
 * a triangle that the ray passes through, or MLRT_NONE. `counters` may be NULL. The ray's numbers may have any finite
 * magnitude.
 */
uint32_t mlrt_trace_segment(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                            mlrt_counters *counters);

/*
 * Replaces the contents of the list by all hits of the ray, each once and in no particular order. If there is no memory
 * for a hit, list->failed is set.
 */
void mlrt_gather_hits(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip,
                      struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
