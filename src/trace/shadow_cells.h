/* SPDX-License-Identifier: MIT */
/*
 * What a light sees of cells that one triangle covers.
 */
#ifndef MLRT_TRACE_SHADOW_CELLS_H
#define MLRT_TRACE_SHADOW_CELLS_H

#include "rays/source.h"
#include "trace/bundle.h"

/*
 * What a point light sees of those packets, or tiles, of a pinhole camera's bundle in `among` (bit per place, some), each
 * of which one triangle covers: in `lit`, the main axis with its sign, and for packets of which that is known slopes, and
 * depths between which their shadow rays look; the waist is the light. Returns these packets. *dark receives those where
 * the light is on the other side of the cover.
 */
uint32_t mlrt_make_lit_cells(const struct mlrt_source *light, const struct mlrt_tree *tree,
                             const struct mlrt_bundle *seen, uint32_t among, struct mlrt_bundle *lit, uint32_t *dark);

#endif
