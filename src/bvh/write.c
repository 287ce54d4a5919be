/* SPDX-License-Identifier: MIT */
/*
 * Writes the hierarchy of boxes that was chosen from the binary one (build.h): how large it is, its arrays, its
 * leaves and nodes in depth-first order. The parts below the tasks are written by one worker each.
 */
#include "bvh/build.h"

#include <math.h>
#include <string.h>

#include "base/message.h"
#include "base/tuning.h"
#include "bvh/unit.h"

/* A child has 29 bits for the number of a quad. */
#define QUAD_LIMIT (UINT32_MAX >> 3)

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
    uint32_t originals = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t number = words[i] & ~MLRT_REFERENCE_COPY;
        uint32_t j = i;
        for (; j > 0 && numbers[j - 1] > number; j--) numbers[j] = numbers[j - 1];
        numbers[j] = number;
        const uint32_t below = originals & ((1u << j) - 1);
        originals = below | (uint32_t) !(words[i] & MLRT_REFERENCE_COPY) << j | (originals & ~below) << 1;
    }
    return originals;
}

/*
 * Prefetches the triangle of a word. The word may be unset memory: so the address is computed as an integer, and
 * nothing depends on it. To prefetch an address where nothing lies does no harm.
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

static void write_leaf(const struct mlrt_bvh_build *build, const struct mlrt_binary_node *node, uint32_t quad)
{
    const struct mlrt_tree *tree = build->tree;
    const int is_usual = tree->bvh.is_usual;
    const uint32_t *words = build->binary.words + node->first;
    uint32_t *numbers = tree->bvh.numbers + 4 * (size_t)quad;
    float *corners = tree->bvh.corners + 36 * (size_t)quad;
    const uint32_t row = 4 * quads_of(node->count);
    for (uint32_t i = 0; i < node->count; i++) prefetch_triangle(tree, words[i + MLRT_WORDS_AHEAD]);
    const uint32_t originals = sort_numbers(words, node->count, numbers);
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
        if (tree->bvh.places != NULL && originals >> place & 1)
            tree->bvh.places[numbers[place]] = mlrt_pack_place(quad, row / 4, place);
    }
    for (uint32_t place = node->count; place < row; place++) {
        numbers[place] = MLRT_NONE;
        write_corners(NULL, row, corners + place);
    }
}

/* ---- nodes --------------------------------------------------------------------------------------------------- */

/* Makes all slots of a node empty. */
static void clear_node(struct mlrt_bvh_node *node)
{
    for (int i = 0; i < MLRT_BVH_WIDTH; i++) {
        for (int k = 0; k < 3; k++) {
            node->lo[k][i] = INFINITY;
            node->hi[k][i] = -INFINITY;
        }
        node->child[i] = 0;
    }
}

static void write_child(struct mlrt_bvh_cursor *cursor, const struct mlrt_binary_node *node, uint32_t child)
{
    const uint32_t slot = cursor->size.slot_count++;
    if (!cursor->parent) return;
    for (int k = 0; k < 3; k++) {
        cursor->parent->lo[k][slot] = mlrt_low_bound(node->lo[k]);
        cursor->parent->hi[k][slot] = 0 - mlrt_low_bound(-node->hi[k]);
    }
    cursor->parent->child[slot] = child;
}

/* Adds the size of the next part, in depth-first order. */
static void add_size(const struct mlrt_bvh_size *part, struct mlrt_bvh_size *sum)
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
    clear_node(cursor->parent);
}

/*
 * Writes what binary node `number` and all below it become, in the cheapest way that takes at most `slots` slots of a
 * node above, into tree->bvh, which has room for it; not all of it if the call is cancelled. Moves the cursor behind
 * it. The subtrees from *next on, which end with one of no node, are left out: sets `slots` and `from` of each, and
 * moves the cursor by its size.
 */
static void write_slots(struct mlrt_bvh_build *build, uint32_t number, uint32_t slots, struct mlrt_bvh_subtree **next,
                        struct mlrt_bvh_cursor *cursor)
{
    const struct mlrt_binary_node *node = &build->binary.nodes[number];
    const struct mlrt_bvh_cursor above = *cursor;
    if ((*next)->node == number) {
        struct mlrt_bvh_subtree *subtree = (*next)++;
        subtree->slots = slots;
        subtree->from = above;
        add_size(&subtree->size, &cursor->size);
        return;
    }
    while (slots > 1 && node->choice[slots] == 0) slots--;
    if (slots > 1) { /* the slots of both children */
        write_slots(build, number + 1, node->choice[slots], next, cursor);
        write_slots(build, node->upper, slots - node->choice[slots], next, cursor);
    } else if (node->choice[1] == 0) {
        write_child(cursor, node, cursor->size.quad_count << 3 | quads_of(node->count));
        if (cursor->parent) write_leaf(build, node, cursor->size.quad_count);
        cursor->size.quad_count += quads_of(node->count);
    } else if (!cursor->parent || !mlrt_is_cancelled(build->progress)) {
        enter_node(node, build->tree, cursor);
        write_slots(build, number + 1, node->choice[0], next, cursor);
        write_slots(build, node->upper, MLRT_NODE_CHILDREN - node->choice[0], next, cursor);
        cursor->size.slot_count = above.size.slot_count + 1;
        cursor->depth = above.depth;
        cursor->parent = above.parent;
    }
}

/* ---- tasks and what is above them ---------------------------------------------------------------------------- */

/* Writes the nodes of sixteen above the tasks from the cursor on, or only moves the cursor. Returns it, moved. */
static struct mlrt_bvh_cursor write_upper(struct mlrt_bvh_build *build, struct mlrt_bvh_cursor cursor)
{
    struct mlrt_bvh_subtree *next = build->work.subtrees;
    write_slots(build, 0, 1, &next, &cursor);
    return cursor;
}

/* Writes what a task becomes, or only moves the cursor. */
static void write_subtree(struct mlrt_bvh_build *build, const struct mlrt_bvh_subtree *subtree,
                          struct mlrt_bvh_cursor *cursor)
{
    struct mlrt_bvh_subtree *none = &build->work.subtrees[build->work.task_count];
    write_slots(build, subtree->node, subtree->slots, &none, cursor);
}

static void measure_task(struct mlrt_bvh_build *build, uint32_t item, uint32_t worker)
{
    struct mlrt_bvh_subtree *subtree = &build->work.subtrees[item];
    struct mlrt_bvh_cursor cursor = {.size = {.depth = subtree->from.depth}, .depth = subtree->from.depth};
    (void)worker;
    write_subtree(build, subtree, &cursor);
    subtree->size = cursor.size;
}

static struct mlrt_bvh_size measure_all(struct mlrt_bvh_build *build)
{
    const struct mlrt_bvh_cursor start = {.depth = 0};
    struct mlrt_bvh_size size = write_upper(build, start).size;
    mlrt_run_step(build, build->work.task_count, measure_task);
    for (uint32_t i = 0; i < build->work.task_count; i++) add_size(&build->work.subtrees[i].size, &size);
    if (build->binary.nodes[0].choice[1] == 0) size.node_count = size.depth = 1;
    return size;
}

static void write_task(struct mlrt_bvh_build *build, uint32_t item, uint32_t worker)
{
    struct mlrt_bvh_subtree *subtree = &build->work.subtrees[item];
    (void)worker;
    write_subtree(build, subtree, &subtree->from);
    mlrt_advance(build->progress, MLRT_LAST_WORK * build->work.tasks[item]->set.count);
}

/*
 * Writes the whole hierarchy. Its root is always a node. If the binary root becomes a leaf, that is the root's only
 * child; else the root is written as the only child of a node `above`, which is dropped.
 */
static int32_t write_all(struct mlrt_bvh_build *build)
{
    struct mlrt_bvh_node above;
    const int is_leaf = build->binary.nodes[0].choice[1] == 0;
    const struct mlrt_bvh_cursor start = {.size = {.node_count = (uint32_t)is_leaf},
                                          .parent = is_leaf ? build->tree->bvh.nodes : &above};
    clear_node(start.parent);
    write_upper(build, start);
    return mlrt_run_step(build, build->work.task_count, write_task);
}

/* ---- triangles that no leaf has as they were given -------------------------------------------------------------- */

/* How many quads have to be behind those of leaves. */
static uint32_t count_given_quads(const struct mlrt_tree *tree)
{
    uint32_t count = (uint32_t)(tree->info.non_finite_count + tree->info.zero_area_count);
    const uint32_t doubtful_count = tree->bvh.is_usual ? 0 : tree->triangle_count;
    for (uint32_t i = 0; i < doubtful_count; i++)
        count += (uint32_t)(mlrt_is_odd(tree, i) && !mlrt_is_left_out(tree, i));
    return (count + 3) / 4;
}

/*
 * Writes the quads behind leaves, and the places of their triangles: of those that have MLRT_NONE, which is no place.
 * The others have theirs from leaves.
 */
static void write_given(struct mlrt_tree *tree)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    uint32_t number = 0;
    for (size_t place = 4 * (size_t)bvh->leaf_quad_count; place < 4 * (size_t)bvh->quad_count; place++) {
        const struct mlrt_triangle *triangle = NULL;
        bvh->numbers[place] = MLRT_NONE;
        while (number < tree->triangle_count && bvh->places[number] != MLRT_NONE) number++;
        if (number < tree->triangle_count) {
            triangle = &tree->triangles[number];
            bvh->numbers[place] = number;
            bvh->places[number] = mlrt_pack_place((uint32_t)(place / 4), 1, place % 4);
        }
        write_corners(triangle, 4, bvh->corners + 36 * (place / 4) + place % 4);
    }
}

/* ---- arrays -------------------------------------------------------------------------------------------------- */

void mlrt_free_bvh(struct mlrt_tree *tree)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    mlrt_free(&tree->memory, bvh->nodes, bvh->node_count, sizeof *bvh->nodes);
    mlrt_free(&tree->memory, bvh->corners, 36 * (size_t)bvh->quad_count + 16, sizeof *bvh->corners);
    mlrt_free(&tree->memory, bvh->numbers, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    mlrt_free(&tree->memory, bvh->places, tree->triangle_count, sizeof *bvh->places);
    *bvh = (struct mlrt_bvh){.nodes = NULL};
}

/* Marks the places of a chunk of triangles as those of triangles in no leaf. Leaves write the places of theirs. */
static void clear_places(struct mlrt_bvh_build *build, uint32_t chunk, uint32_t worker)
{
    const uint32_t count = mlrt_item_size(build->tree->triangle_count, MLRT_CHUNK_SIZE, chunk);
    uint32_t *places = build->tree->bvh.places + (size_t)chunk * MLRT_CHUNK_SIZE;
    (void)worker;
    memset(places, 0xFF, count * sizeof *places);
}

static int32_t allocate_result(struct mlrt_bvh_build *build, const struct mlrt_bvh_size *size)
{
    struct mlrt_tree *tree = build->tree;
    struct mlrt_bvh *bvh = &tree->bvh;
    if (size->node_count > MLRT_BVH_NODE_LIMIT || size->quad_count > QUAD_LIMIT) {
        return mlrt_fail(MLRT_ERROR_TOO_LARGE,
                         "meshes: the tree would have more than %lu nodes, or %lu quads of triangles",
                         (unsigned long)MLRT_BVH_NODE_LIMIT, (unsigned long)QUAD_LIMIT);
    }
    const uint64_t quad_count = size->quad_count + count_given_quads(tree);
    const int has_places = tree->triangle_count > 0 && quad_count < MLRT_PLACE_QUADS;
    bvh->node_count = (uint32_t)size->node_count;
    bvh->leaf_quad_count = (uint32_t)size->quad_count;
    bvh->quad_count = has_places ? (uint32_t)quad_count : bvh->leaf_quad_count;
    if (bvh->quad_count == 0) return MLRT_OK;
    bvh->corners =
        mlrt_reuse(&tree->memory, build->references.boxes, build->limits.capacity * (size_t)MLRT_REFERENCE_ROOM,
                   (36 * (size_t)bvh->quad_count + 16) * sizeof *bvh->corners);
    build->references.boxes = NULL;
    if (has_places) bvh->places = mlrt_allocate(&tree->memory, tree->triangle_count, sizeof *bvh->places);
    bvh->nodes = mlrt_allocate(&tree->memory, bvh->node_count, sizeof *bvh->nodes);
    bvh->numbers = mlrt_allocate(&tree->memory, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    if (bvh->corners == NULL || bvh->numbers == NULL || bvh->nodes == NULL || (has_places && bvh->places == NULL))
        return MLRT_ERROR_OUT_OF_MEMORY;
    if (bvh->quad_count > bvh->leaf_quad_count) mlrt_run_step(build, build->limits.chunk_count, clear_places);
    memset(bvh->corners + 36 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->corners);
    memset(bvh->numbers + 4 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->numbers);
    return MLRT_OK;
}

int32_t mlrt_write_hierarchy(struct mlrt_bvh_build *build)
{
    struct mlrt_bvh_size size = {.depth = 0};
    const int has_leaves = build->references.whole.count > 0;
    if (has_leaves) size = measure_all(build);
    if (mlrt_is_cancelled(build->progress)) return MLRT_ERROR_CANCELLED;
    int32_t status = allocate_result(build, &size);
    if (status == MLRT_OK && has_leaves) status = write_all(build);
    if (status != MLRT_OK) return status;
    write_given(build->tree);
    build->tree->info.depth = size.depth;
    return MLRT_OK;
}
