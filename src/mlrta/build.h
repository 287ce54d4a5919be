/* SPDX-License-Identifier: MIT */
/*
 * Builds the nodes and leaf entries of a kd-tree over the triangles that the tree already holds.
 */
#ifndef MLRT_MLRTA_BUILD_H
#define MLRT_MLRTA_BUILD_H

#include "base/progress.h"
#include "scene/tree.h"

/*
 * Before the call, tree->triangles and triangle_count are set, `options` is an mlrt_kdtree_options that was checked (or
 * NULL), and the floating-point environment is the library's. `progress` (may be NULL) advances by MLRT_KDTREE_WORK per
 * triangle. Returns a status:
 *
 *   - MLRT_OK: tree->kdtree, bounds and tree->info are set, except info's triangle_count, memory_size and
 *     build_seconds, which the caller knows.
 *   - MLRT_ERROR_OUT_OF_MEMORY, or MLRT_ERROR_TOO_LARGE for more than 2^30 - 1 triangles: nodes and references are
 *     NULL, and tree->memory holds as much as before.
 *   - MLRT_ERROR_CANCELLED: likewise, unless the call is cancelled after the last node: then nodes and references are
 *     set.
 */
int32_t mlrt_build_nodes(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress);

/* The work of building per triangle, where copying one is MLRT_COPY_WORK (scene/meshes.h). */
#define MLRT_KDTREE_WORK 60.0

/* Guesses how many bytes mlrt_build_nodes will hold at its end, and at most while it runs. */
struct mlrt_demand mlrt_foresee_nodes(const void *options, uint32_t triangle_count);

#endif
