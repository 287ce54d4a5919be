/* SPDX-License-Identifier: MIT */
/*
 * Triangles by number in a hierarchy of boxes: see places.h.
 */
#include "bvh/places.h"

#include <math.h>
#include <string.h>

#include "bvh/node.h"
#include "bvh/unit.h"

/* 1 if no leaf has the corners of the triangle. */
static int is_only_given(const struct mlrt_tree *tree, uint32_t number)
{
    struct mlrt_triangle in_units;
    return mlrt_is_left_out(tree, number) ||
           !mlrt_triangle_in_units(&tree->triangles[number], tree->bvh.unit, &in_units);
}

/* 1 if each triangle is in a leaf, with its corners. */
static int is_all_in_leaves(const struct mlrt_tree *tree)
{
    return tree->info.non_finite_count + tree->info.zero_area_count == 0 && mlrt_has_usual_triangles(tree);
}

uint32_t mlrt_count_given_quads(const struct mlrt_tree *tree)
{
    uint32_t count = 0;
    if (is_all_in_leaves(tree)) return 0;
    for (uint32_t i = 0; i < tree->triangle_count; ++i) count += (uint32_t)is_only_given(tree, i);
    return (count + 3) / 4;
}

/* A triangle in several leaves has the place in the one that is found last. */
static void place_leaf(struct mlrt_bvh *bvh, uint32_t child)
{
    const uint32_t first = mlrt_bvh_offset(child), quad_count = mlrt_bvh_quad_count(child);
    const uint32_t *numbers = bvh->numbers + 4 * (size_t)first;
    for (uint32_t place = 0; place < 4 * quad_count && numbers[place] != MLRT_NONE; ++place) {
        bvh->places[numbers[place]] = mlrt_pack_place(first, quad_count, place);
    }
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

static void write_all_given(struct mlrt_tree *tree)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    uint32_t index = 0;
    for (uint32_t i = 0; i < tree->triangle_count; ++i) {
        if (is_only_given(tree, i)) write_given(tree, index++, i);
    }
    for (; index % 4; ++index) {
        const size_t quad = bvh->leaf_quad_count + index / 4;
        for (uint32_t i = 0; i < 9; ++i) bvh->corners[36 * quad + 4 * i + index % 4] = NAN;
        bvh->numbers[4 * quad + index % 4] = MLRT_NONE;
    }
}

void mlrt_place_triangles(struct mlrt_tree *tree)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    for (uint32_t i = 0; i < bvh->node_count; ++i) {
        for (uint32_t slot = 0; slot < MLRT_BVH_WIDTH; ++slot) {
            if (mlrt_bvh_quad_count(bvh->nodes[i].child[slot])) place_leaf(bvh, bvh->nodes[i].child[slot]);
        }
    }
    if (bvh->quad_count > bvh->leaf_quad_count) write_all_given(tree);
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
