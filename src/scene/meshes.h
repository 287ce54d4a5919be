/* SPDX-License-Identifier: MIT */
/* The caller's meshes: checked, and copied into a tree. */
#ifndef MLRT_SCENE_MESHES_H
#define MLRT_SCENE_MESHES_H

#include "base/progress.h"
#include "scene/tree.h"

#define MLRT_TRIANGLE_LIMIT ((1u << 30) - 1) /* leaves count in 30 bits */

/* Checks a caller's array of meshes, and counts their triangles. Returns a status. */
int32_t mlrt_check_meshes(const mlrt_mesh *meshes, size_t mesh_count, uint32_t *triangle_count);

/* Mesh i of an array that was checked, with defaults resolved: strides, index_size, mask. */
mlrt_mesh mlrt_mesh_at(const mlrt_mesh *meshes, size_t i);

/* 1 if one of these meshes has a mask other than MLRT_MASK_ALL. */
int mlrt_have_masks(const mlrt_mesh *meshes, size_t mesh_count);

/*
 * Copies a triangle of a mesh of mlrt_mesh_at, mesh `i`. Returns MLRT_OK, or MLRT_ERROR_INDEX_RANGE if the index of a
 * vertex is out of range, which gets a message if `is_told`.
 */
int32_t mlrt_copy_triangle(const mlrt_mesh *mesh, size_t i, size_t triangle, int is_told, struct mlrt_triangle *copy);

/* The work of copying a triangle: the unit of a build's progress. */
#define MLRT_COPY_WORK 1.0

/*
 * Copies meshes that were checked into a tree: its triangles, by the workers of the pool, and its tables of ids and
 * masks. tree->triangle_count is the count of mlrt_check_meshes. Returns a status. mlrt_free_meshes frees the arrays,
 * also after an error.
 */
int32_t mlrt_copy_meshes(const mlrt_mesh *meshes, size_t mesh_count, mlrt_pool *pool, struct mlrt_progress *progress,
                         struct mlrt_tree *tree);

void mlrt_free_meshes(struct mlrt_tree *tree);

#endif
