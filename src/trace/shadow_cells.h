/* SPDX-License-Identifier: MIT */
/*
 * The cells of a point light: bundles of shadow rays that are not made yet.
 */
#ifndef MLRT_TRACE_SHADOW_CELLS_H
#define MLRT_TRACE_SHADOW_CELLS_H

#include "rays/source.h"
#include "trace/bundle.h"

/*
 * Makes `shadows`, a bundle without rays whose waist is a point light: the shadow rays of the cells `among` (bits by
 * place, at least one) of `seen`, a pinhole camera's bundle. One triangle covers each of these cells. Returns those
 * that could be made. *dark receives the cells whose cover has the light on its other side.
 */
uint32_t mlrt_make_shadow_cells(const struct mlrt_source *light, const struct mlrt_tree *tree,
                                const struct mlrt_bundle *seen, uint32_t among, struct mlrt_bundle *shadows,
                                uint32_t *dark);

#endif
