/* SPDX-License-Identifier: MIT */
/*
 * One ray through the kd-tree, the textbook way, in double.
 */
#ifndef MLRT_MLRTA_RAY_H
#define MLRT_MLRTA_RAY_H

#include "exact/hit_list.h"

/* Traces a ray through the cells of the kd-tree; arguments and result are those of mlrt_trace_boxes (bvh/ray.h). */
uint32_t mlrt_trace_cells(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
