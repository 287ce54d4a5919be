/* SPDX-License-Identifier: MIT */
/*
 * One ray through the kd-tree, the textbook way, in double.
 */
#ifndef MLRT_MLRTA_RAY_H
#define MLRT_MLRTA_RAY_H

#include "exact/hit_list.h"

/* As mlrt_trace_boxes (bvh/ray.h), in the cells of a kd-tree. */
uint32_t mlrt_trace_cells(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
