/* SPDX-License-Identifier: MIT */
/*
 * Masks: a ray sees the triangles whose mask has a bit in common with its own. Nobody asks here who has all bits.
 */
#ifndef MLRT_SCENE_MASKS_H
#define MLRT_SCENE_MASKS_H

#include "exact/predicate.h"
#include "scene/tree.h"

/* Does a ray with this mask pass through the triangle as if it were not there? */
static inline int mlrt_is_hidden(const struct mlrt_tree *tree, uint32_t number, uint32_t mask)
{
    return tree->masks && !(tree->masks[number] & mask);
}

/* Of the places `among` of a list of triangles, a bit each, those that a ray with this mask sees. */
uint32_t mlrt_visible_places(const struct mlrt_tree *tree, const uint32_t *numbers, uint32_t among, uint32_t mask);

/* Of the rays `lanes`, those that see the triangle; `masks` are theirs. */
uint32_t mlrt_seeing_lanes(const struct mlrt_tree *tree, uint32_t number, const uint32_t *masks, uint32_t lanes);

#endif
