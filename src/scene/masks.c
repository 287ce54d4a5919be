/* SPDX-License-Identifier: MIT */
/* Masks of many triangles or of many rays: see masks.h. */
#include "scene/masks.h"

#include "base/platform.h"

uint32_t mlrt_visible_places(const struct mlrt_tree *tree, const uint32_t *numbers, uint32_t among, uint32_t mask)
{
    uint32_t visible = among;
    for (; tree->masks && among; among &= among - 1) {
        const uint32_t place = mlrt_lowest_bit(among);
        if (mlrt_is_hidden(tree, numbers[place], mask)) visible &= ~(1u << place);
    }
    return visible;
}

uint32_t mlrt_seeing_lanes(const struct mlrt_tree *tree, uint32_t number, const uint32_t *masks, uint32_t lanes)
{
    uint32_t seeing = lanes;
    for (; tree->masks && lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        if (mlrt_is_hidden(tree, number, masks[lane])) seeing &= ~(1u << lane);
    }
    return seeing;
}
