/* SPDX-License-Identifier: MIT */
/* See triangle_numbers.h. */
#include "scene/triangle_numbers.h"

void mlrt_find_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t *mesh, uint32_t *triangle)
{
    *mesh = *triangle = MLRT_NONE;
    if (number == MLRT_NONE) return;
    const uint32_t position = mlrt_mesh_of_triangle(tree, number);
    *mesh = tree->meshes.ids[position];
    *triangle = number - tree->meshes.first[position];
}

struct mlrt_mesh_range mlrt_find_mesh(const struct mlrt_tree *tree, uint32_t mesh_id)
{
    const struct mlrt_mesh_range none = {0, 0};
    uint32_t below = 0, above = tree->meshes.count;
    while (below < above) {
        uint32_t middle = below + (above - below) / 2;
        if (tree->meshes.ids[tree->meshes.by_id[middle]] < mesh_id)
            below = middle + 1;
        else
            above = middle;
    }
    if (below == tree->meshes.count) return none;
    const uint32_t mesh = tree->meshes.by_id[below];
    if (tree->meshes.ids[mesh] != mesh_id) return none;
    return (struct mlrt_mesh_range){tree->meshes.first[mesh], tree->meshes.first[mesh + 1] - tree->meshes.first[mesh]};
}

uint32_t mlrt_triangle_number(const struct mlrt_tree *tree, uint32_t mesh_id, uint32_t triangle)
{
    const struct mlrt_mesh_range mesh = mlrt_find_mesh(tree, mesh_id);
    return triangle < mesh.count ? mesh.first + triangle : MLRT_NONE;
}
