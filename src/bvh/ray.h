/* SPDX-License-Identifier: MIT */
/*
 * Traces one ray through the hierarchy of boxes, in double: the part of run/trace_ray.h for trees of boxes.
 */
#ifndef MLRT_BVH_RAY_H
#define MLRT_BVH_RAY_H

#include "exact/hit_list.h"

/*
 * As mlrt_trace_segment (run/trace_ray.h). With a list, adds all hits to it, and a triangle of several leaves more than
 * once; then no hit ends the search, and the result has no meaning.
 */
uint32_t mlrt_trace_boxes(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
