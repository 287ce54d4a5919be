/* SPDX-License-Identifier: MIT */
/*
 * The caller's meshes: checked, and copied into a tree.
 */
#ifndef MLRT_SCENE_MESHES_H
#define MLRT_SCENE_MESHES_H

#include "base/host.h"
#include "base/progress.h"
#include "scene/tree.h"

#define MLRT_TRIANGLE_LIMIT ((1u << 30) - 1) /* leaves count in 30 bits */

/* Checks an array of meshes, and counts their triangles. Returns a status. */
int32_t mlrt_check_meshes(const mlrt_mesh *meshes, size_t mesh_count, uint32_t *triangle_count);

/* A mesh of an array that was checked, with defaults resolved: strides, index_size, mask. */
mlrt_mesh mlrt_mesh_at(const mlrt_mesh *meshes, size_t i);

/* Does one of these meshes have a mask, other than all bits? */
int mlrt_have_masks(const mlrt_mesh *meshes, size_t mesh_count);

/* Copies a triangle of such a mesh: 0 if one of its vertices does not exist, whose index then is *index. */
int mlrt_copy_triangle(const mlrt_mesh *mesh, size_t triangle, struct mlrt_triangle *copy, uint64_t *index);

/* What progress counts a mesh's triangle as, which is copied. */
#define MLRT_COPY_WORK 1.0

/*
 * Sets what a tree holds of meshes that were checked, tree->triangle_count among it: triangles, and the tables of ids
 * and masks, which mlrt_free_meshes frees. On error some of that may be there.
 */
int32_t mlrt_copy_meshes(const mlrt_mesh *meshes, size_t mesh_count, const struct mlrt_voice *voice,
                         struct mlrt_progress *progress, struct mlrt_tree *tree);

void mlrt_free_meshes(struct mlrt_tree *tree);

#endif
