/* SPDX-License-Identifier: MIT */
/* Traces one ray through the hierarchy of boxes, in double: trace_ray of its structure (job/structure.h). */
#ifndef MLRT_BVH_RAY_H
#define MLRT_BVH_RAY_H

#include "exact/hit_list.h"

uint32_t mlrt_trace_boxes(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
