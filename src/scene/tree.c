/* SPDX-License-Identifier: MIT */
/* A tree of any structure: an empty one, and which triangles are left out. */
#include "scene/tree.h"

struct mlrt_tree *mlrt_allocate_tree(const struct mlrt_structure *structure, const struct mlrt_memory *memory)
{
    struct mlrt_memory own = *memory;
    struct mlrt_tree *tree = mlrt_allocate_zeroed(&own, 1, sizeof *tree);
    if (!tree) return NULL;
    tree->structure = structure;
    tree->memory = own;
    return tree;
}

int mlrt_is_left_out(const struct mlrt_tree *tree, uint32_t number)
{
    uint64_t counts[2] = {0, 0};
    if (tree->info.non_finite_count + tree->info.zero_area_count == 0) return 0;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    return !mlrt_keep_triangle(&triangle, &counts[0], &counts[1]);
}
