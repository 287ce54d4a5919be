/* SPDX-License-Identifier: MIT */
/*
 * One ray through a tree: see trace_ray.h.
 */
#include "run/trace_ray.h"

#include "bvh/ray.h"
#include "mlrta/ray.h"
#include "scene/tree.h"

static int is_bvh(const struct mlrt_tree *tree)
{
    return tree->structure == MLRT_STRUCTURE_BVH;
}

uint32_t mlrt_trace_segment(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                            mlrt_counters *counters)
{
    return is_bvh(tree) ? mlrt_trace_boxes(tree, ray, skip, any, NULL, counters)
                        : mlrt_trace_cells(tree, ray, skip, any, NULL, counters);
}

void mlrt_gather_hits(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip,
                      struct mlrt_hit_list *list, mlrt_counters *counters)
{
    list->count = 0;
    if (is_bvh(tree)) {
        mlrt_trace_boxes(tree, ray, skip, 0, list, counters);
    } else {
        mlrt_trace_cells(tree, ray, skip, 0, list, counters);
    }
    mlrt_remove_repetitions(list);
}
