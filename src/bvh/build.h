/* SPDX-License-Identifier: MIT */
/* Builds the hierarchy of boxes over triangles that are already in a tree. */
#ifndef MLRT_BVH_BUILD_H
#define MLRT_BVH_BUILD_H

#include "base/progress.h"
#include "scene/tree.h"

/*
 * On entry, tree->triangles and triangle_count are set and the rest is 0, `options` is checked (or NULL), and the
 * floating-point environment is the library's. Returns a status. With MLRT_OK, tree->bvh, bounds and tree->info are set,
 * except what of info the caller knows. After an error the hierarchy
 * is empty, and tree->memory holds what it held on entry. MLRT_ERROR_TOO_LARGE: more nodes or quads than node.h has
 * bits for. Adds about MLRT_BVH_WORK per triangle to `progress` (NULL = none).
 */
int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_tree_options *options, struct mlrt_progress *progress);

/* The work per triangle, where copying a triangle is 1 (MLRT_COPY_WORK, scene/meshes.h). */
#define MLRT_BVH_WORK 10.0

/*
 * About how many bytes a hierarchy of mlrt_build_bvh takes when it is finished, and at most while it is built, with an
 * mlrt_tree_options that was checked.
 */
struct mlrt_demand mlrt_foresee_bvh(const void *tree_options, uint32_t triangle_count);

/* Frees the hierarchy of mlrt_build_bvh. tree->bvh is empty then. */
void mlrt_free_bvh(struct mlrt_tree *tree);

#endif
