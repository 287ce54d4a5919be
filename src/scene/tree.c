/* SPDX-License-Identifier: MIT */
/*
 * Which triangles of a tree are left out, whatever its structure.
 */
#include "scene/tree.h"

#include "exact/predicate.h"

int mlrt_is_left_out(const struct mlrt_tree *tree, uint32_t number)
{
    if (tree->info.non_finite_count + tree->info.zero_area_count == 0) return 0;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    return !mlrt_triangle_is_finite(&triangle) || !mlrt_triangle_has_area(&triangle);
}
