/* SPDX-License-Identifier: MIT */
/*
 * Builds the hierarchy of boxes over triangles that are already in a tree.
 */
#ifndef MLRT_BVH_BUILD_H
#define MLRT_BVH_BUILD_H

#include "base/progress.h"
#include "scene/tree.h"

/*
 * On entry: tree->triangles and triangle_count are set, options is checked (or NULL), the floating-point environment is
 * ours. On return with MLRT_OK: tree->bvh, bounds, float_safe and tree->info are set (except triangle_count, structure,
 * memory_size and build_seconds, which the caller knows). After an error the hierarchy is empty, and nothing else is
 * held in tree->memory than on entry. MLRT_ERROR_TOO_LARGE: more nodes or quads than node.h has bits for. Progress (NULL
 * = none) goes on by MLRT_BVH_WORK per triangle, about.
 */
int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_tree_options *options, struct mlrt_progress *progress);

/* In units of what copying a triangle takes (meshes.h). */
#define MLRT_BVH_WORK 10.0

/* What mlrt_build_bvh will hold in the end, about, and at most at one time. */
struct mlrt_demand mlrt_foresee_bvh(const mlrt_tree_options *options, uint32_t triangle_count);

/* Frees what mlrt_build_bvh made. */
void mlrt_free_bvh(struct mlrt_tree *tree);

#endif
