/* SPDX-License-Identifier: MIT */
/* A tree of any structure: an empty one, the mesh of a triangle, which triangles are left out, and masks. */
#include "scene/tree.h"

#include "base/platform.h"

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

uint32_t mlrt_visible_places(const struct mlrt_tree *tree, const uint32_t *numbers, uint32_t among, uint32_t mask)
{
    uint32_t visible = among;
    for (; tree->masks && among; among &= among - 1) {
        const uint32_t place = mlrt_lowest_bit(among);
        if (mlrt_is_hidden(tree, numbers[place], mask)) visible &= ~(1u << place);
    }
    return visible;
}

uint32_t mlrt_seeing_lanes(const struct mlrt_tree *tree, uint32_t number, const uint32_t *masks, uint32_t lanes)
{
    uint32_t seeing = lanes;
    for (; tree->masks && lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        if (mlrt_is_hidden(tree, number, masks[lane])) seeing &= ~(1u << lane);
    }
    return seeing;
}
