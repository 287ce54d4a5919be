/* SPDX-License-Identifier: MIT */
/*
 * The cells of a point light: bundles of shadow rays that are not made yet.
 */
#ifndef MLRT_TRACE_SHADOW_CELLS_H
#define MLRT_TRACE_SHADOW_CELLS_H

#include "rays/source.h"
#include "trace/bundle.h"

/*
 * Finds the cells of a point light for the cells `among` (bits by place, at least one) of a pinhole camera's bundle,
 * each of which one triangle covers, and makes a bundle without rays of them, whose waist is the light. Returns the
 * cells that could be found. *dark receives the cells whose cover has the light on its other side.
 */
uint32_t mlrt_make_lit_cells(const struct mlrt_source *light, const struct mlrt_tree *tree,
                             const struct mlrt_bundle *seen, uint32_t among, struct mlrt_bundle *lit, uint32_t *dark);

#endif
