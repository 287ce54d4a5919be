/* SPDX-License-Identifier: MIT */
/* Triangles by number, in the order of the meshes, and by the ids that the caller knows: mesh, and place in it. */
#ifndef MLRT_SCENE_TRIANGLE_NUMBERS_H
#define MLRT_SCENE_TRIANGLE_NUMBERS_H

#include "scene/tree.h"

/* Returns the position of the mesh that triangle `number` belongs to. */
static inline uint32_t mlrt_mesh_of_triangle(const struct mlrt_tree *tree, uint32_t number)
{
    uint32_t below = 0, above = tree->meshes.count;
    while (above - below > 1) {
        uint32_t middle = below + (above - below) / 2;
        if (tree->meshes.first[middle] <= number) {
            below = middle;
        } else {
            above = middle;
        }
    }
    return below;
}

/* Sets the ids of triangle `number`; those of a miss for MLRT_NONE. */
void mlrt_find_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t *mesh, uint32_t *triangle);

/* The numbers of a mesh's triangles. */
struct mlrt_mesh_range {
    uint32_t first;
    uint32_t count;
};

/* The triangles of the mesh with this id; count = 0 if there is no such mesh. */
struct mlrt_mesh_range mlrt_find_mesh(const struct mlrt_tree *tree, uint32_t mesh_id);

/* The number of triangle `triangle` of the mesh with this id; MLRT_NONE if there is no such triangle. */
uint32_t mlrt_triangle_number(const struct mlrt_tree *tree, uint32_t mesh_id, uint32_t triangle);

#endif
