/* SPDX-License-Identifier: MIT */
/*
 * Triangles by number in a hierarchy of boxes: see places.h.
 */
#include "bvh/places.h"

#include <math.h>
#include <string.h>

#include "bvh/node.h"
#include "bvh/unit.h"

uint32_t mlrt_count_given_quads(const struct mlrt_tree *tree)
{
    uint32_t count = (uint32_t)(tree->info.non_finite_count + tree->info.zero_area_count);
    for (uint32_t i = 0; !mlrt_has_usual_triangles(tree) && i < tree->triangle_count; ++i) {
        count += (uint32_t)(mlrt_is_odd(tree, i) && !mlrt_is_left_out(tree, i));
    }
    return (count + 3) / 4;
}

/* Writes a triangle to a place behind the leaves. */
static void write_given(struct mlrt_tree *tree, uint32_t index, uint32_t number)
{
    const uint32_t quad = tree->bvh.leaf_quad_count + index / 4, place = index % 4;
    float *corner = tree->bvh.corners + 36 * (size_t)quad + place;
    for (uint32_t i = 0; i < 9; ++i) memcpy(&corner[4 * i], &tree->triangles[number].v[0][i], sizeof *corner);
    tree->bvh.numbers[4 * (size_t)quad + place] = number;
    tree->bvh.places[number] = mlrt_pack_place(quad, 1, place);
}

void mlrt_write_given(struct mlrt_tree *tree)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    uint32_t index = 0;
    if (bvh->quad_count == bvh->leaf_quad_count) return;
    for (uint32_t i = 0; i < tree->triangle_count; ++i) {
        if (bvh->places[i] == MLRT_NONE) write_given(tree, index++, i);
    }
    for (; index % 4; ++index) {
        const size_t quad = bvh->leaf_quad_count + index / 4;
        for (uint32_t i = 0; i < 9; ++i) bvh->corners[36 * quad + 4 * i + index % 4] = NAN;
        bvh->numbers[4 * quad + index % 4] = MLRT_NONE;
    }
}

void mlrt_drop_order(struct mlrt_tree *tree)
{
    if (!tree->bvh.places) return;
    mlrt_free(&tree->memory, tree->triangles, tree->triangle_count, sizeof *tree->triangles);
    tree->triangles = NULL;
    mlrt_read_by_places(tree);
}

void mlrt_read_by_places(struct mlrt_tree *tree)
{
    const struct mlrt_bvh *bvh = &tree->bvh;
    tree->by_number = (struct mlrt_triangles){bvh->corners, bvh->places, bvh->leaf_quad_count, 1 / bvh->unit};
}

const char *mlrt_check_places(const struct mlrt_tree *tree)
{
    for (uint32_t i = 0; i < tree->triangle_count; ++i) {
        const uint32_t packed = tree->bvh.places[i], quad_count = mlrt_quad_count_of(packed);
        if ((uint64_t)mlrt_first_quad_of(packed) + quad_count > tree->bvh.quad_count) return "a place is in no quad";
        if (mlrt_place_in_leaf(packed) >= 4 * quad_count) return "a place is in no quad";
    }
    return NULL;
}
