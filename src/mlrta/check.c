/* SPDX-License-Identifier: MIT */
/*
 * Statistics of a tree and its invariants: see check.h. Neither walk is recursive: in a damaged tree a recursion might
 * never end.
 */
#include "mlrta/kdtree.h"

#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "exact/predicate.h"
#include "mlrta/split.h"

/* A node to visit, with its cell. */
struct visit {
    uint32_t node;
    uint32_t depth;
    struct mlrt_box cell;
};

/* The nodes that wait to be visited: at most one upper child per level, and both children of the deepest node. */
struct walk {
    struct visit waiting[MLRT_DEPTH_LIMIT + 2];
    uint32_t count;
};

static void start_walk(const struct mlrt_tree *tree, struct walk *walk)
{
    walk->waiting[0].node = 0;
    walk->waiting[0].depth = 0;
    walk->waiting[0].cell = tree->bounds;
    walk->count = 1;
}

/* Makes the children of an inner node those that are visited next, the lower one first. */
static void push_children(const struct mlrt_tree *tree, const struct visit *parent, struct walk *walk)
{
    const struct mlrt_node *node = &tree->kdtree.nodes[parent->node];
    uint32_t axis = mlrt_node_axis(node);
    struct visit *above = &walk->waiting[walk->count++], *below = &walk->waiting[walk->count++];
    *above = *below = *parent;
    above->node = mlrt_node_child(node) + 1;
    below->node = mlrt_node_child(node);
    above->depth = below->depth = parent->depth + 1;
    above->cell.lo[axis] = below->cell.hi[axis] = node->u.split;
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
        uint32_t first_word;
        memcpy(&first_word, &tree->kdtree.nodes[i].u, sizeof first_word);
        hash = hash_word(hash_word(hash, first_word), tree->kdtree.nodes[i].word);
    }
    for (uint32_t i = 0; i < tree->kdtree.reference_count && !mlrt_is_cancelled_in_round(progress, i + 1); i++)
        hash = hash_word(hash, tree->kdtree.references[i]);
    return hash;
}

void mlrt_find_float_safety(struct mlrt_tree *tree)
{
    int is_safe = 1;
    for (int k = 0; k < 3; k++)
        is_safe &= mlrt_is_float_safe(tree->bounds.lo[k]) && mlrt_is_float_safe(tree->bounds.hi[k]);
    for (uint32_t i = 0; i < tree->kdtree.node_count; i++) {
        const struct mlrt_node *node = &tree->kdtree.nodes[i];
        if (!mlrt_node_is_leaf(node) && !mlrt_is_float_safe(node->u.split)) is_safe = 0;
    }
    tree->kdtree.float_safe = is_safe;
}

void mlrt_measure_tree(struct mlrt_tree *tree, double traversal_cost, double intersection_cost,
                       struct mlrt_progress *progress)
{
    mlrt_tree_info *info = &tree->info;
    double area = mlrt_half_area(&tree->bounds), cost = 0;
    struct walk walk;
    info->depth = 0;
    info->node_count = tree->kdtree.node_count;
    info->reference_count = tree->kdtree.reference_count;
    info->leaf_count = info->empty_leaf_count = 0;
    memcpy(info->bounds_min, tree->bounds.lo, sizeof info->bounds_min);
    memcpy(info->bounds_max, tree->bounds.hi, sizeof info->bounds_max);
    for (start_walk(tree, &walk); walk.count > 0;) {
        struct visit visit = walk.waiting[--walk.count];
        const struct mlrt_node *node = &tree->kdtree.nodes[visit.node];
        if (mlrt_is_cancelled_in_round(progress, visit.node + 1)) return;
        double part = area > 0 ? mlrt_half_area(&visit.cell) / area : 1;
        info->depth = visit.depth > info->depth ? visit.depth : info->depth;
        if (mlrt_node_is_leaf(node)) {
            info->leaf_count++;
            info->empty_leaf_count += mlrt_leaf_count(node) == 0;
            cost += part * intersection_cost * (double)mlrt_leaf_count(node);
        } else {
            cost += part * traversal_cost;
            push_children(tree, &visit, &walk);
        }
    }
    info->sah_cost = cost / intersection_cost;
    info->tree_hash = hash_tree(tree, progress);
    mlrt_find_float_safety(tree);
}

/* ---- invariants ---------------------------------------------------------------------------------------------- */

/* Returns NULL, or the error. The leaf's entries must begin at `next`, behind those of all leaves before it. */
static const char *check_leaf(const struct mlrt_tree *tree, const struct mlrt_node *leaf, uint32_t next)
{
    const uint32_t count = mlrt_leaf_count(leaf), *entries = tree->kdtree.references + next;
    if (leaf->u.offset != next || count > tree->kdtree.reference_count - next)
        return "a leaf's entries are not where depth-first order has them";
    for (uint32_t i = 0; i < count; i++) {
        if (entries[i] >= tree->triangle_count) return "an entry is not a triangle";
        if (mlrt_is_left_out(tree, entries[i])) return "a leaf refers to a triangle that was to be left out";
        if (i > 0 && entries[i - 1] >= entries[i]) return "I5: the entries of a leaf are not ascending";
    }
    return NULL;
}

/* Returns NULL, or the error. The first child must be node `next`, the first that no node before it has as a child. */
static const char *check_inner(const struct mlrt_tree *tree, const struct visit *visit, uint32_t next)
{
    const struct mlrt_node *node = &tree->kdtree.nodes[visit->node];
    uint32_t axis = mlrt_node_axis(node);
    if (mlrt_node_child(node) != next || tree->kdtree.node_count - next < 2)
        return "I1: children are not where depth-first order has them";
    if (!(visit->cell.lo[axis] <= node->u.split && node->u.split <= visit->cell.hi[axis]))
        return "I2: a plane is outside of its cell";
    if (visit->depth >= MLRT_DEPTH_LIMIT) return "I4: a path is too long";
    return NULL;
}

const char *mlrt_check_nodes(const struct mlrt_tree *tree)
{
    uint32_t next = 1, next_entry = 0;
    struct walk walk;
    if (tree->kdtree.node_count % 2 == 0) return "I1: the number of nodes is even";
    for (start_walk(tree, &walk); walk.count > 0;) {
        struct visit visit = walk.waiting[--walk.count];
        const struct mlrt_node *node = &tree->kdtree.nodes[visit.node];
        const char *wrong =
            mlrt_node_is_leaf(node) ? check_leaf(tree, node, next_entry) : check_inner(tree, &visit, next);
        if (wrong != NULL) return wrong;
        if (mlrt_node_is_leaf(node)) {
            next_entry += mlrt_leaf_count(node);
        } else {
            push_children(tree, &visit, &walk);
            next += 2;
        }
    }
    if (next != tree->kdtree.node_count) return "I1: there are nodes without a parent";
    return next_entry == tree->kdtree.reference_count ? NULL : "there are entries without a leaf";
}
