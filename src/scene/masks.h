/* SPDX-License-Identifier: MIT */
/*
 * Masks: a ray sees a triangle if their masks have a bit in common. A ray with MLRT_MASK_ALL sees every triangle.
 */
#ifndef MLRT_SCENE_MASKS_H
#define MLRT_SCENE_MASKS_H

#include "scene/tree.h"

/* 1 if a ray with this mask passes through the triangle as if it were not there. */
static inline int mlrt_is_hidden(const struct mlrt_tree *tree, uint32_t number, uint32_t mask)
{
    return tree->masks && !(tree->masks[number] & mask);
}

/* Those places of a list of triangle numbers, among the bits of `among`, whose triangles a ray with this mask sees. */
uint32_t mlrt_visible_places(const struct mlrt_tree *tree, const uint32_t *numbers, uint32_t among, uint32_t mask);

/* Those lanes, among the bits of `lanes`, whose rays see the triangle. masks[i] is the mask of lane i. */
uint32_t mlrt_seeing_lanes(const struct mlrt_tree *tree, uint32_t number, const uint32_t *masks, uint32_t lanes);

#endif
