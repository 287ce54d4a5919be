/* SPDX-License-Identifier: MIT */
/* Chooses and writes nodes of sixteen: see collapse.h. */
#include "bvh/collapse.h"

#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "base/tuning.h"
#include "bvh/split.h"
#include "bvh/unit.h"

void mlrt_choose_leaf(const struct mlrt_bvh_costs *costs, float area, struct mlrt_binary_node *node,
                      struct mlrt_forest_costs *result)
{
    memset(node->choice, 0, sizeof node->choice);
    result->cost[1] = area * set_cost(costs, node->count);
    result->slot_count = 1;
}

/*
 * The least cost of two children in `slots` slots, at least 2 and at most those that they can use. Sets *lower_slots to
 * the number that the lower child gets.
 */
static float distribute(const struct mlrt_forest_costs children[2], int slots, uint8_t *lower_slots)
{
    const int spare = slots - children[1].slot_count, first = spare > 1 ? spare : 1;
    const int last = children[0].slot_count < slots ? children[0].slot_count : slots - 1;
    float best = children[0].cost[first] + children[1].cost[slots - first];
    *lower_slots = (uint8_t)first;
    for (int i = first + 1; i <= last; i++) {
        float cost = children[0].cost[i] + children[1].cost[slots - i];
        if (cost >= best) continue;
        best = cost;
        *lower_slots = (uint8_t)i;
    }
    return best;
}

void mlrt_choose_cut(const struct mlrt_bvh_costs *costs, float area, const struct mlrt_forest_costs children[2],
                     struct mlrt_binary_node *node, struct mlrt_forest_costs *result)
{
    const int usable = children[0].slot_count + children[1].slot_count;
    const int most = usable < MLRT_NODE_CHILDREN ? usable : MLRT_NODE_CHILDREN;
    float best = area * costs->node + distribute(children, most, &node->choice[0]);
    memset(node->choice + 1, 0, sizeof node->choice - 1);
    node->choice[1] = 1;
    if (node->count <= MLRT_LEAF_TRIANGLES) {
        float leaf = area * set_cost(costs, node->count);
        if (leaf <= best) {
            best = leaf;
            node->choice[1] = 0;
        }
    }
    result->cost[1] = best;
    result->slot_count = most < MLRT_NODE_CHILDREN ? most : MLRT_NODE_CHILDREN - 1;
    for (int i = 2; i <= result->slot_count; i++) {
        float cost = distribute(children, i, &node->choice[i]);
        if (cost < best)
            best = cost;
        else
            node->choice[i] = 0;
        result->cost[i] = best;
    }
}

static uint32_t quads_of(uint32_t count)
{
    return (count + 3) / 4;
}

/* ---- leaves -------------------------------------------------------------------------------------------------- */

/*
 * Sets the numbers of a leaf from the words of its references. Ascending, so that of triangles hit at one t the one
 * that the hit rule prefers is tested first. Returns the places of those that are no copies.
 */
static uint32_t sort_numbers(const uint32_t *words, uint32_t count, uint32_t *numbers)
{
    uint32_t first = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t number = words[i] & ~MLRT_REFERENCE_COPY;
        uint32_t j = i;
        for (; j > 0 && numbers[j - 1] > number; j--) numbers[j] = numbers[j - 1];
        numbers[j] = number;
        const uint32_t below = first & ((1u << j) - 1);
        first = below | (uint32_t) !(words[i] & MLRT_REFERENCE_COPY) << j | (first & ~below) << 1;
    }
    return first;
}

/*
 * Prefetches the triangle of a word. Where there is no reference, the word is unset: so the address is not computed as
 * that of an element, and nothing is decided by it. To prefetch an address where nothing lies does no harm.
 */
MLRT_INLINE void prefetch_triangle(const struct mlrt_tree *tree, uint32_t word)
{
    const uintptr_t number = word & ~MLRT_REFERENCE_COPY;
    mlrt_prefetch((const void *)((uintptr_t)tree->triangles + number * sizeof *tree->triangles));
}

/* Writes a triangle of a leaf whose rows have `row` floats; NULL = it has no corners. */
MLRT_INLINE void write_corners(const struct mlrt_triangle *triangle, uint32_t row, float *corner)
{
    for (uint32_t i = 0; i < 9; i++) corner[i * row] = triangle != NULL ? triangle->v[i / 3][i % 3] : NAN;
}

static void write_leaf(const struct mlrt_binary_tree *binary, const struct mlrt_binary_node *node,
                       const struct mlrt_tree *tree, uint32_t quad)
{
    const int is_usual = tree->bvh.is_usual;
    const uint32_t *words = binary->words + node->first;
    uint32_t *numbers = tree->bvh.numbers + 4 * (size_t)quad;
    float *corners = tree->bvh.corners + 36 * (size_t)quad;
    const uint32_t row = 4 * quads_of(node->count);
    for (uint32_t i = 0; i < node->count; i++) prefetch_triangle(tree, words[i + MLRT_WORDS_AHEAD]);
    const uint32_t first = sort_numbers(words, node->count, numbers);
    for (uint32_t place = 0; place < node->count; place++) {
        const struct mlrt_triangle *given = &tree->triangles[numbers[place]];
        struct mlrt_triangle in_units;
        if (is_usual) {
            write_corners(given, row, corners + place);
        } else if (mlrt_triangle_in_units(given, tree->bvh.unit, &in_units)) {
            write_corners(&in_units, row, corners + place);
        } else {
            write_corners(NULL, row, corners + place);
            continue;
        }
        if (tree->bvh.places != NULL && first >> place & 1)
            tree->bvh.places[numbers[place]] = mlrt_pack_place(quad, row / 4, place);
    }
    for (uint32_t place = node->count; place < row; place++) {
        numbers[place] = MLRT_NONE;
        write_corners(NULL, row, corners + place);
    }
}

/* ---- nodes --------------------------------------------------------------------------------------------------- */

void mlrt_clear_node(struct mlrt_bvh_node *node)
{
    for (int i = 0; i < MLRT_BVH_WIDTH; i++) {
        for (int k = 0; k < 3; k++) {
            node->lo[k][i] = INFINITY;
            node->hi[k][i] = -INFINITY;
        }
        node->child[i] = 0;
    }
}

/* A low bound; -inf below -MLRT_BVH_FAR (unit.h). */
static float low_bound(float lo)
{
    return lo < -MLRT_BVH_FAR ? -INFINITY : lo;
}

static void write_child(struct mlrt_bvh_cursor *cursor, const struct mlrt_binary_node *node, uint32_t child)
{
    const uint32_t slot = cursor->size.slot_count++;
    if (!cursor->parent) return;
    for (int k = 0; k < 3; k++) {
        cursor->parent->lo[k][slot] = low_bound(node->lo[k]);
        cursor->parent->hi[k][slot] = 0 - low_bound(-node->hi[k]);
    }
    cursor->parent->child[slot] = child;
}

void mlrt_add_size(const struct mlrt_bvh_size *part, struct mlrt_bvh_size *sum)
{
    sum->node_count += part->node_count;
    sum->quad_count += part->quad_count;
    sum->slot_count += part->slot_count;
    if (part->depth > sum->depth) sum->depth = part->depth;
}

/* Writes a binary node as a node of sixteen without children, and moves the cursor to its children. */
static void enter_node(const struct mlrt_binary_node *node, struct mlrt_tree *tree, struct mlrt_bvh_cursor *cursor)
{
    const uint32_t number = cursor->size.node_count++;
    write_child(cursor, node, number << 3);
    cursor->size.slot_count = 0;
    if (++cursor->depth > cursor->size.depth) cursor->size.depth = cursor->depth;
    if (!cursor->parent) return;
    cursor->parent = &tree->bvh.nodes[number];
    mlrt_clear_node(cursor->parent);
}

/* What the calls of `write_slots` for all binary nodes have in common. */
struct writing {
    const struct mlrt_binary_tree *binary;
    struct mlrt_tree *tree;
    struct mlrt_progress *progress;
    struct mlrt_forest *next; /* the next that is left out; NULL = there is none */
};

/* Writes a binary node in the cheapest way that takes at most `slots` slots. */
static void write_slots(struct writing *writing, uint32_t number, uint32_t slots, struct mlrt_bvh_cursor *cursor)
{
    const struct mlrt_binary_node *node = &writing->binary->nodes[number];
    const struct mlrt_bvh_cursor above = *cursor;
    if (writing->next != NULL && writing->next->node == number) {
        struct mlrt_forest *forest = writing->next++;
        forest->slots = slots;
        forest->from = above;
        mlrt_add_size(&forest->size, &cursor->size);
        return;
    }
    while (slots > 1 && node->choice[slots] == 0) slots--;
    if (slots > 1) { /* the slots of both children */
        write_slots(writing, number + 1, node->choice[slots], cursor);
        write_slots(writing, node->upper, slots - node->choice[slots], cursor);
    } else if (node->choice[1] == 0) {
        write_child(cursor, node, cursor->size.quad_count << 3 | quads_of(node->count));
        if (cursor->parent) write_leaf(writing->binary, node, writing->tree, cursor->size.quad_count);
        cursor->size.quad_count += quads_of(node->count);
    } else if (!cursor->parent || !mlrt_is_cancelled(writing->progress)) {
        enter_node(node, writing->tree, cursor);
        write_slots(writing, number + 1, node->choice[0], cursor);
        write_slots(writing, node->upper, MLRT_NODE_CHILDREN - node->choice[0], cursor);
        cursor->size.slot_count = above.size.slot_count + 1;
        cursor->depth = above.depth;
        cursor->parent = above.parent;
    }
}

void mlrt_write_forest(const struct mlrt_binary_tree *binary, uint32_t number, uint32_t slots, struct mlrt_tree *tree,
                       struct mlrt_progress *progress, struct mlrt_forest *next, struct mlrt_bvh_cursor *cursor)
{
    struct writing writing = {binary, tree, progress, next};
    write_slots(&writing, number, slots, cursor);
}
