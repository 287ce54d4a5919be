/* SPDX-License-Identifier: MIT */
/* Triangles by number in a hierarchy of boxes: see node.h. */
#include "bvh/node.h"

#include <math.h>
#include <string.h>

#include "bvh/unit.h"

uint32_t mlrt_count_given_quads(const struct mlrt_tree *tree)
{
    uint32_t count = (uint32_t)(tree->info.non_finite_count + tree->info.zero_area_count);
    const uint32_t doubtful_count = tree->bvh.is_usual ? 0 : tree->triangle_count;
    for (uint32_t i = 0; i < doubtful_count; ++i)
        count += (uint32_t)(mlrt_is_odd(tree, i) && !mlrt_is_left_out(tree, i));
    return (count + 3) / 4;
}

void mlrt_write_given(struct mlrt_tree *tree)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    uint32_t number = 0;
    for (size_t place = 4 * (size_t)bvh->leaf_quad_count; place < 4 * (size_t)bvh->quad_count; ++place) {
        struct mlrt_triangle triangle = {{{NAN, NAN, NAN}, {NAN, NAN, NAN}, {NAN, NAN, NAN}}};
        bvh->numbers[place] = MLRT_NONE;
        while (number < tree->triangle_count && bvh->places[number] != MLRT_NONE) ++number;
        if (number < tree->triangle_count) {
            triangle = tree->triangles[number];
            bvh->numbers[place] = number;
            bvh->places[number] = mlrt_pack_place((uint32_t)(place / 4), 1, place % 4);
        }
        float *corner = bvh->corners + 36 * (place / 4) + place % 4;
        for (uint32_t i = 0; i < 9; ++i) memcpy(&corner[4 * i], &triangle.v[i / 3][i % 3], sizeof *corner);
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
        if (mlrt_first_quad_of(packed) + quad_count > tree->bvh.quad_count ||
            mlrt_place_in_leaf(packed) >= 4 * quad_count)
            return "P1: a place is in no quad";
    }
    return NULL;
}
