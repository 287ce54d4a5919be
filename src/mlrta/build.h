/* SPDX-License-Identifier: MIT */
/*
 * Builds the nodes and leaf entries of a tree over triangles that are already in it.
 */
#ifndef MLRT_MLRTA_BUILD_H
#define MLRT_MLRTA_BUILD_H

#include "base/progress.h"
#include "scene/tree.h"

/*
 * On entry: tree->triangles and triangle_count are set, options is checked (or NULL), the floating-point environment is
 * ours. On return with MLRT_OK: nodes, references, bounds, float_safe and tree->info are set (except triangle_count,
 * memory_size and build_seconds, which the caller knows). On MLRT_ERROR_OUT_OF_MEMORY: nodes and references are NULL,
 * and nothing else is held in tree->memory than on entry. So with MLRT_ERROR_TOO_LARGE: over 2^30 - 1 triangles. And
 * with MLRT_ERROR_CANCELLED. Progress (NULL = none) goes on by MLRT_KDTREE_WORK per triangle.
 */
int32_t mlrt_build_nodes(struct mlrt_tree *tree, const mlrt_kdtree_options *options, struct mlrt_progress *progress);

/* In units of what copying a triangle takes (meshes.h). */
#define MLRT_KDTREE_WORK 60.0

/* What mlrt_build_nodes will hold in the end, and at most at one time: a guess. */
struct mlrt_demand mlrt_foresee_nodes(const mlrt_kdtree_options *options, uint32_t triangle_count);

#endif
