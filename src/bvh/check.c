/* SPDX-License-Identifier: MIT */
/* The invariants of a hierarchy of boxes: see node.h. */
#include "bvh/node.h"

#include <math.h>
#include <string.h>

#include "bvh/unit.h"

const char *mlrt_check_places(const struct mlrt_tree *tree)
{
    for (uint32_t i = 0; tree->bvh.places != NULL && i < tree->triangle_count; i++) {
        const uint32_t packed = tree->bvh.places[i], quad_count = mlrt_quad_count_of(packed);
        if (mlrt_first_quad_of(packed) + quad_count > tree->bvh.quad_count ||
            mlrt_place_in_leaf(packed) >= 4 * quad_count)
            return "P1: a place is in no quad";
    }
    return NULL;
}

static int has_no_corners(const float *corners, uint32_t row)
{
    for (uint32_t i = 0; i < 9; i++)
        if (corners[i * row] == corners[i * row]) return 0;
    return 1;
}

/* 1 if a place has the corners of the triangle in units, bit for bit. `row` is the number of places of the leaf. */
static int has_corners_of(const float *corners, uint32_t row, const struct mlrt_triangle *triangle, float unit)
{
    struct mlrt_triangle in_units;
    uint32_t difference = 0, expected[9];
    if (!mlrt_triangle_in_units(triangle, unit, &in_units)) return has_no_corners(corners, row);
    memcpy(expected, &in_units, sizeof expected);
    for (uint32_t i = 0; i < 9; i++) {
        uint32_t bits;
        memcpy(&bits, &corners[i * row], sizeof bits);
        difference |= bits ^ expected[i];
    }
    return difference == 0;
}

/* Prefetches a triangle, or its place. */
static void prefetch_triangle(const struct mlrt_tree *tree, uint32_t number)
{
    if (tree->bvh.places != NULL)
        mlrt_prefetch(&tree->bvh.places[number]);
    else
        mlrt_prefetch(&tree->triangles[number]);
}

/* Checks the places of a leaf. Adds to *placed_count the triangles that have their place here. */
static const char *check_leaf(const struct mlrt_tree *tree, uint32_t child, uint32_t *placed_count)
{
    uint32_t place_count = 4 * mlrt_bvh_quad_count(child), count = mlrt_bvh_leaf_count(&tree->bvh, child);
    const uint32_t *numbers = tree->bvh.numbers + 4 * (size_t)mlrt_bvh_offset(child);
    const float *corners = tree->bvh.corners + 36 * (size_t)mlrt_bvh_offset(child);
    if (count == 0 || count + 3 < place_count) return "B5: a leaf has a quad without triangles";
    for (uint32_t place = 0; place < count; place++) {
        if (numbers[place] >= tree->triangle_count) return "B5: a number is not a triangle's";
        prefetch_triangle(tree, numbers[place]);
        for (uint32_t other = 0; other < place; other++)
            if (numbers[other] == numbers[place]) return "B5: a leaf holds a triangle twice";
    }
    for (uint32_t place = 0; place < place_count; place++) {
        if (place >= count) {
            if (numbers[place] != MLRT_NONE) return "B5: a triangle behind an empty place";
            if (!has_no_corners(corners + place, place_count)) return "B5: an empty place has corners";
            continue;
        }
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, numbers[place]);
        if (mlrt_is_left_out(tree, numbers[place])) return "a leaf holds a triangle that was to be left out";
        if (!has_corners_of(corners + place, place_count, &triangle, tree->bvh.unit))
            return "B5: corners are not those of the triangle";
        if (tree->bvh.places != NULL)
            *placed_count += tree->bvh.places[numbers[place]] ==
                             mlrt_pack_place(mlrt_bvh_offset(child), mlrt_bvh_quad_count(child), place);
    }
    return NULL;
}

/* What comes next in depth-first order. */
struct walk {
    uint32_t next_node;
    uint32_t next_quad;
    uint32_t placed_count; /* triangles that have their place in the leaves so far */
};

static const char *check_empty_slots(const struct mlrt_bvh_node *node, int first)
{
    for (int i = first; i < MLRT_BVH_WIDTH; i++)
        for (int k = 0; k < 3; k++)
            if (node->child[i] != 0 || node->lo[k][i] != INFINITY || node->hi[k][i] != -INFINITY)
                return "B2: an empty slot is not empty";
    return first == 0 ? "B2: a node has no children" : NULL;
}

/* 1 if the slot's box is a box, within the bounds; 0 if a bound is a NaN. */
static int is_box_within(const struct mlrt_bvh_node *node, int slot, const struct mlrt_box *bounds)
{
    for (int k = 0; k < 3; k++) {
        const float lo = node->lo[k][slot], hi = node->hi[k][slot];
        if (!(bounds->lo[k] <= lo && lo <= hi && hi <= bounds->hi[k])) return 0;
    }
    return 1;
}

static const char *check_node(const struct mlrt_tree *tree, uint32_t depth, struct walk *walk);

/* Checks a child of a node at a depth. */
static const char *check_child(const struct mlrt_tree *tree, uint32_t child, uint32_t depth, struct walk *walk)
{
    const uint32_t quad_count = mlrt_bvh_quad_count(child);
    if (quad_count != 0) {
        if (quad_count > 4) return "B5: a leaf has too many quads";
        if (mlrt_bvh_offset(child) != walk->next_quad || quad_count > tree->bvh.leaf_quad_count - walk->next_quad)
            return "a leaf's quads are not where depth-first order has them";
        walk->next_quad += quad_count;
        return check_leaf(tree, child, &walk->placed_count);
    }
    if (mlrt_bvh_offset(child) != walk->next_node || walk->next_node >= tree->bvh.node_count)
        return "B1: a child is not where depth-first order has it";
    return depth < MLRT_BVH_DEPTH_LIMIT ? check_node(tree, depth + 1, walk) : "B4: a path is too long";
}

/* Checks the next node and all below it. It ends, since children must lie behind their parents. */
static const char *check_node(const struct mlrt_tree *tree, uint32_t depth, struct walk *walk)
{
    const struct mlrt_bvh_node *node = &tree->bvh.nodes[walk->next_node++];
    int slot = 0;
    for (; slot < MLRT_BVH_WIDTH && node->child[slot] != 0; slot++) {
        if (!is_box_within(node, slot, &tree->bvh.whole)) return "B3: a box is not one, or not within the bounds";
        const char *wrong = check_child(tree, node->child[slot], depth, walk);
        if (wrong != NULL) return wrong;
    }
    return check_empty_slots(node, slot);
}

/*
 * Checks the quads behind the leaves, and that all triangles have their places: `placed_count` in leaves, the others in
 * these quads. No triangle counts twice, since a place is in one quad.
 */
static const char *check_given(const struct mlrt_tree *tree, uint32_t placed_count)
{
    const struct mlrt_bvh *bvh = &tree->bvh;
    for (uint32_t quad = bvh->leaf_quad_count; quad < bvh->quad_count; quad++) {
        for (uint32_t place = 0; place < 4; place++) {
            const uint32_t number = bvh->numbers[4 * (size_t)quad + place];
            if (number == MLRT_NONE) continue;
            if (number >= tree->triangle_count || bvh->places[number] != mlrt_pack_place(quad, 1, place))
                return "P1: a number has its place elsewhere";
            placed_count++;
        }
    }
    return bvh->places == NULL || placed_count == tree->triangle_count ? NULL : "P1: a triangle is not at its place";
}

const char *mlrt_check_boxes(const struct mlrt_tree *tree)
{
    struct walk walk = {0, 0, 0};
    const char *wrong = tree->bvh.node_count > 0 ? check_node(tree, 1, &walk) : NULL;
    if (wrong != NULL) return wrong;
    if (walk.next_node != tree->bvh.node_count) return "B1: there are nodes without a parent";
    if (walk.next_quad != tree->bvh.leaf_quad_count) return "there are quads without a leaf";
    return check_given(tree, walk.placed_count);
}
