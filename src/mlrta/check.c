/* SPDX-License-Identifier: MIT */
/* Statistics of a tree and its invariants: see kdtree.h. */
#include "mlrta/kdtree.h"

#include <string.h>

#include "mlrta/split.h"
#include "scene/reach.h"

/* Sets the cells of a node's children. */
static void split_cell(const struct mlrt_node *node, const struct mlrt_box *cell, struct mlrt_box children[2])
{
    const uint32_t axis = mlrt_node_axis(node);
    children[0] = children[1] = *cell;
    children[0].hi[axis] = children[1].lo[axis] = node->u.split;
}

/* ---- statistics ---------------------------------------------------------------------------------------------- */

/* FNV-1a, 64 bits: http://www.isthe.com/chongo/tech/comp/fnv. Words go in by their bytes, the lowest first. */
#define HASH_START  0xCBF29CE484222325u
#define HASH_FACTOR 0x100000001B3u

static uint64_t hash_word(uint64_t hash, uint32_t word)
{
    for (int shift = 0; shift < 32; shift += 8) hash = (hash ^ (word >> shift & 255)) * HASH_FACTOR;
    return hash;
}

static uint64_t hash_tree(const struct mlrt_tree *tree, struct mlrt_progress *progress)
{
    uint64_t hash = HASH_START;
    for (uint32_t i = 0; i < tree->kdtree.node_count && !mlrt_is_cancelled_in_round(progress, i + 1); i++) {
        const struct mlrt_node *node = &tree->kdtree.nodes[i];
        hash = hash_word(hash_word(hash, node->u.offset), node->word); /* or the bits of u.split */
    }
    for (uint32_t i = 0; i < tree->kdtree.reference_count && !mlrt_is_cancelled_in_round(progress, i + 1); i++)
        hash = hash_word(hash, tree->kdtree.references[i]);
    return hash;
}

void mlrt_find_float_limits(struct mlrt_tree *tree)
{
    int is_safe = 1;
    for (int k = 0; k < 3; k++)
        is_safe &= mlrt_is_float_safe(tree->bounds.lo[k]) && mlrt_is_float_safe(tree->bounds.hi[k]);
    for (uint32_t i = 0; i < tree->kdtree.node_count; i++) {
        const struct mlrt_node *node = &tree->kdtree.nodes[i];
        if (!mlrt_node_is_leaf(node) && !mlrt_is_float_safe(node->u.split)) is_safe = 0;
    }
    tree->kdtree.float_safe = is_safe;
    tree->kdtree.reach = mlrt_reach_of(&tree->bounds);
}

/* Costs, the area of the scene, and the sum of costs times area so far. */
struct measure {
    double traversal_cost, intersection_cost, area, cost;
};

/* Adds a node and all below it to tree->info and to the sum. Returns 0 if the call is cancelled. */
static int measure_node(struct mlrt_tree *tree, uint32_t number, uint32_t depth, const struct mlrt_box *cell,
                        struct mlrt_progress *progress, struct measure *measure)
{
    const struct mlrt_node *node = &tree->kdtree.nodes[number];
    const double part = measure->area > 0 ? mlrt_half_area(cell) / measure->area : 1;
    struct mlrt_box children[2];
    if (mlrt_is_cancelled_in_round(progress, number + 1)) return 0;
    tree->info.depth = depth > tree->info.depth ? depth : tree->info.depth;
    if (mlrt_node_is_leaf(node)) {
        tree->info.leaf_count++;
        tree->info.empty_leaf_count += mlrt_leaf_count(node) == 0;
        measure->cost += part * measure->intersection_cost * (double)mlrt_leaf_count(node);
        return 1;
    }
    measure->cost += part * measure->traversal_cost;
    split_cell(node, cell, children);
    return measure_node(tree, mlrt_node_child(node), depth + 1, &children[0], progress, measure) &&
           measure_node(tree, mlrt_node_child(node) + 1, depth + 1, &children[1], progress, measure);
}

void mlrt_measure_tree(struct mlrt_tree *tree, double traversal_cost, double intersection_cost,
                       struct mlrt_progress *progress)
{
    mlrt_tree_info *info = &tree->info;
    struct measure measure = {traversal_cost, intersection_cost, mlrt_half_area(&tree->bounds), 0};
    info->node_count = tree->kdtree.node_count;
    info->reference_count = tree->kdtree.reference_count;
    memcpy(info->bounds_min, tree->bounds.lo, sizeof info->bounds_min);
    memcpy(info->bounds_max, tree->bounds.hi, sizeof info->bounds_max);
    if (!measure_node(tree, 0, 0, &tree->bounds, progress, &measure)) return;
    info->sah_cost = measure.cost / intersection_cost;
    info->tree_hash = hash_tree(tree, progress);
    mlrt_find_float_limits(tree);
}

/* ---- invariants ---------------------------------------------------------------------------------------------- */

/* What comes next in depth-first order: the children of an inner node, the entries of a leaf. */
struct walk {
    uint32_t next, next_entry;
};

static const char *check_leaf(const struct mlrt_tree *tree, const struct mlrt_node *leaf, struct walk *walk)
{
    const uint32_t count = mlrt_leaf_count(leaf), *entries = tree->kdtree.references + walk->next_entry;
    if (leaf->u.offset != walk->next_entry || count > tree->kdtree.reference_count - walk->next_entry)
        return "a leaf's entries are not where depth-first order has them";
    for (uint32_t i = 0; i < count; i++) {
        if (entries[i] >= tree->triangle_count) return "an entry is not a triangle";
        if (mlrt_is_left_out(tree, entries[i])) return "a leaf refers to a triangle that was to be left out";
        if (i > 0 && entries[i - 1] >= entries[i]) return "I5: the entries of a leaf are not ascending";
    }
    walk->next_entry += count;
    return NULL;
}

/* Checks a node and all below it. It ends, since children must lie behind their parents. */
static const char *check_node(const struct mlrt_tree *tree, uint32_t number, uint32_t depth,
                              const struct mlrt_box *cell, struct walk *walk)
{
    const struct mlrt_node *node = &tree->kdtree.nodes[number];
    const uint32_t axis = mlrt_node_axis(node), child = mlrt_node_child(node);
    struct mlrt_box children[2];
    if (mlrt_node_is_leaf(node)) return check_leaf(tree, node, walk);
    if (child != walk->next || tree->kdtree.node_count - child < 2)
        return "I1: children are not where depth-first order has them";
    if (!(cell->lo[axis] <= node->u.split && node->u.split <= cell->hi[axis]))
        return "I2: a plane is outside of its cell";
    if (depth >= MLRT_DEPTH_LIMIT) return "I4: a path is too long";
    walk->next += 2;
    split_cell(node, cell, children);
    const char *wrong = check_node(tree, child, depth + 1, &children[0], walk);
    return wrong != NULL ? wrong : check_node(tree, child + 1, depth + 1, &children[1], walk);
}

const char *mlrt_check_nodes(const struct mlrt_tree *tree)
{
    struct walk walk = {1, 0};
    if (tree->kdtree.node_count % 2 == 0) return "I1: the number of nodes is even";
    const char *wrong = check_node(tree, 0, 0, &tree->bounds, &walk);
    if (wrong != NULL) return wrong;
    if (walk.next != tree->kdtree.node_count) return "I1: there are nodes without a parent";
    return walk.next_entry == tree->kdtree.reference_count ? NULL : "there are entries without a leaf";
}
