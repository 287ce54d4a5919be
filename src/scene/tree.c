/* SPDX-License-Identifier: MIT */
/*
 * Facts about a tree that both structures use: the mesh of a triangle, whether its bounds are float-safe, and which
 * triangles are left out.
 */
#include "scene/tree.h"

#include "exact/predicate.h"

uint32_t mlrt_mesh_of_triangle(const struct mlrt_tree *tree, uint32_t number)
{
    uint32_t below = 0, above = tree->mesh_count;
    while (above - below > 1) {
        uint32_t middle = below + (above - below) / 2;
        if (tree->mesh_first[middle] <= number) {
            below = middle;
        } else {
            above = middle;
        }
    }
    return below;
}

int mlrt_has_safe_bounds(const struct mlrt_tree *tree)
{
    int is_safe = 1;
    for (int k = 0; k < 3; k++)
        is_safe &= mlrt_is_float_safe(tree->bounds.lo[k]) && mlrt_is_float_safe(tree->bounds.hi[k]);
    return is_safe;
}

int mlrt_is_left_out(const struct mlrt_tree *tree, uint32_t number)
{
    if (tree->info.non_finite_count + tree->info.zero_area_count == 0) return 0;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    return !mlrt_triangle_is_finite(&triangle) || !mlrt_triangle_has_area(&triangle);
}
