/* SPDX-License-Identifier: MIT */
/*
 * One ray through the hierarchy of boxes, in double: trace_ray.h for trees that have nothing else.
 */
#ifndef MLRT_BVH_RAY_H
#define MLRT_BVH_RAY_H

#include "exact/hit_list.h"

/*
 * As mlrt_trace_segment; with a list all hits are added to it, some of them more than once, none ends the search, and
 * what is returned means nothing.
 */
uint32_t mlrt_trace_boxes(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
