/* SPDX-License-Identifier: MIT */
/*
 * The builder of the kd-tree as a whole.
 *
 * The subtree of a cell depends only on its references, its box and its shares of the limits on depth, references,
 * nodes and bad splits. So the workers of the pool build parts of the tree at the same time: large cells are cut in
 * two, each by one worker, round after round, until all are small; a small one is built by one worker, with the
 * references of the current cell and of the siblings that wait in memory. At the end the calling thread joins the parts
 * in depth-first order. Neither the tree nor the order of any sum depends on the number of workers.
 */
#include "mlrta/kdtree.h"

#include <math.h>
#include <string.h>

#include "base/platform.h"
#include "base/scheduler.h"
#include "mlrta/part.h"

/* A leaf's entry count and a child's node number have 30 bits. */
#define COUNT_LIMIT 0x3FFFFFFFu

/*
 * Cells of more references than this, and than this part of the triangles, are cut into parts. `bench --study build`
 * shows what several workers gain: less than their number, as the first rounds have fewer cells than there are workers.
 */
#define PART_SIZE  2048
#define PART_SHARE 512

/*
 * The most nodes of all parts. The rest of COUNT_LIMIT is for the levels above: each of MLRT_DEPTH_LIMIT has at most
 * 2^32 / PART_SIZE cells, so all have fewer than 2^28 nodes.
 */
#define PART_NODE_LIMIT (COUNT_LIMIT / 2)

/* ---- settings ------------------------------------------------------------------------------------------------ */

/*
 * Intersection cost: with 1, 2.5, 8 a 4x4 packet from the root visits 55.9, 58.3, 59.6 cells of conference and tests
 * 5.2, 4.1, 3.8 triangles, by 3.2, 6.1, 8.7 nodes per triangle. So leaves that are smaller than those of 2.5 do not
 * pay.
 *
 * Empty factor: expected costs for 1, 0.9, 0.8, 0.7 differ by less than 1 %.
 *
 * Minimum cell: with 1e-8, 1e-6, 2e-5, 1e-4, packets visit 64.8, 59.6, 56.9, 55.0 cells of conference and 333, 146,
 * 42.9, 30.4 of a dense scan (dragon, 7.8 M triangles); at 2e-5 these match the 42.2 that the paper counts for its own
 * dragon without beams. Build times fall by a third at each step. But leaves grow: frames of a ship seen from inside
 * (cruiser) take 169, 220, 432 ms at 1e-6, 4e-6, 2e-5, those of the dragon 969, 749, 694 ms. So 1e-6 is a compromise.
 */
static const struct mlrt_preset PRESETS[] = {
    {{1.0, 2.5, 0.9}, 2e-5}, /* MLRT_KDTREE_PAPER */
    {{1.0, 1.0, 0.9}, 1e-6}, /* MLRT_KDTREE_TUNED */
};

/*
 * Options with all defaults resolved. The depth is the usual 8 + 1.3 log2 n, plus 12 levels for empty sides and covered
 * planes. With 60 levels in its place, expected costs are the same in four digits (erw6, conference, cruiser, dragon, 2
 * million triangles of rooms). With 36 levels they are at most 0.4 % higher, with 32 up to 4 %, with 28 up to 31 %
 * (examples/depth.c).
 */
static struct mlrt_kdtree_settings resolve_options(const mlrt_kdtree_options *options, uint32_t triangle_count)
{
    struct mlrt_kdtree_settings settings = {PRESETS[options->preset], options->rules_off, options->max_depth,
                                            options->max_references, options->pool};
    if (options->traversal_cost > 0) settings.preset.model.traversal = options->traversal_cost;
    if (options->intersection_cost > 0) settings.preset.model.intersection = options->intersection_cost;
    if (settings.depth_limit == 0) settings.depth_limit = (uint32_t)(20 + 1.3 * log2((double)triangle_count + 1));
    if (settings.depth_limit > MLRT_DEPTH_LIMIT) settings.depth_limit = MLRT_DEPTH_LIMIT;
    if (settings.reference_limit == 0) settings.reference_limit = 8 * (uint64_t)triangle_count + 1024;
    if (settings.reference_limit > UINT32_MAX) settings.reference_limit = UINT32_MAX;
    return settings;
}

/* ---- parts --------------------------------------------------------------------------------------------------- */

/* Builds a part with a root that is its node 0. Returns 0 if there is no memory, or the call is cancelled. */
static int build_part(struct mlrt_kdtree_part *part)
{
    struct mlrt_kdtree_build *build = part->build;
    part->built.node_count = 1;
    if (!mlrt_make_room(build, &part->built.nodes, part->cell.count / 2 + 1, sizeof(struct mlrt_node)) ||
        !mlrt_make_room(build, &part->built.entries, part->cell.count + 1, sizeof(uint32_t)) ||
        !mlrt_build_cell(part, &part->cell))
        return 0;
    mlrt_release_room(build, &part->built.references, sizeof(struct mlrt_reference));
    return 1;
}

/*
 * Cuts a part in two, of which the upper one keeps its array of references. Or builds it, if its root becomes a leaf.
 * Returns 0 if there is no memory, or the call is cancelled.
 */
static int cut_part(struct mlrt_kdtree_part *part)
{
    struct mlrt_kdtree_build *build = part->build;
    struct mlrt_kdtree_part *lower = mlrt_part_at(build, part->lower), *upper = lower + 1;
    struct mlrt_kdtree_cell whole = part->cell, sides[2];
    const enum mlrt_choice choice = mlrt_cut_cell(part, &whole, &part->split, sides);
    if (choice == MLRT_CHOICE_FAILED) return 0;
    if (choice == MLRT_CHOICE_LEAF) {
        part->lower = 0;
        return build_part(part);
    }
    lower->build = upper->build = build;
    lower->cell = sides[0];
    upper->cell = sides[1];
    lower->cell.first = 0;
    upper->built.references = part->built.references;
    part->built.references = (struct mlrt_growing_array){NULL, 0};
    if (!mlrt_make_room(build, &lower->built.references, sides[0].count, sizeof(struct mlrt_reference))) return 0;
    if (sides[0].count > 0)
        memcpy(lower->built.references.elements, mlrt_reference_at(upper, sides[0].first),
               sides[0].count * sizeof(struct mlrt_reference));
    return mlrt_set_room(build, &upper->built.references, sides[1].count, sizeof(struct mlrt_reference));
}

static int32_t run_part(void *work, uint32_t item, uint32_t worker)
{
    struct mlrt_kdtree_build *build = work;
    struct mlrt_kdtree_part *part = mlrt_part_at(build, build->parts.first + item);
    (void)worker;
    if (part->build == NULL) return 0;
    mlrt_fp_environment environment;
    mlrt_enter_fp_environment(&environment);
    const double share = (double)part->cell.reference_limit / (double)mlrt_part_at(build, 0)->cell.reference_limit;
    part->built.node_limit = (uint32_t)(PART_NODE_LIMIT * share);
    const int done = part->lower != 0 ? cut_part(part) : build_part(part);
    mlrt_release_room(build, &part->built.scratch, sizeof(double));
    mlrt_leave_fp_environment(&environment);
    return done ? 0 : MLRT_ERROR_OUT_OF_MEMORY;
}

/*
 * Works on all parts, beginning with the one that there is. In each round the workers take those that the last round
 * made: they cut the large ones, and build the others. Returns 0 if there is no memory, or the call is cancelled.
 */
static int build_parts(struct mlrt_kdtree_build *build)
{
    while (build->parts.first < build->parts.count) {
        const uint32_t end = build->parts.count, count = end - build->parts.first;
        if (!mlrt_make_room(build, &build->parts.all, (size_t)end + 2 * (size_t)count, sizeof(struct mlrt_kdtree_part)))
            return 0;
        memset(mlrt_part_at(build, end), 0, 2 * (size_t)count * sizeof(struct mlrt_kdtree_part));
        for (uint32_t i = build->parts.first; i < end; i++) {
            if (mlrt_part_at(build, i)->cell.count <= build->parts.size) continue;
            mlrt_part_at(build, i)->lower = build->parts.count;
            build->parts.count += 2;
        }
        if (mlrt_run_items(build->settings.pool, count, run_part, build) != 0) return 0;
        build->parts.first = end;
    }
    return 1;
}

/* ---- the whole tree ------------------------------------------------------------------------------------------ */

static void release_part(struct mlrt_kdtree_build *build, struct mlrt_kdtree_part *part)
{
    mlrt_release_room(build, &part->built.references, sizeof(struct mlrt_reference));
    mlrt_release_room(build, &part->built.nodes, sizeof(struct mlrt_node));
    mlrt_release_room(build, &part->built.entries, sizeof(uint32_t));
    mlrt_release_room(build, &part->built.scratch, sizeof(double));
}

/* Copies a built part into the whole tree, where part->cell.node is its root. Returns 0 if there is no memory. */
static int append_part(struct mlrt_kdtree_part *whole, struct mlrt_kdtree_part *part)
{
    const uint32_t shift = whole->built.node_count - 1; /* node 1 of the part is the next of the whole tree */
    if (!mlrt_make_room(whole->build, &whole->built.nodes, (size_t)shift + part->built.node_count,
                        sizeof(struct mlrt_node)) ||
        !mlrt_make_room(whole->build, &whole->built.entries, (size_t)whole->built.entry_count + part->built.entry_count,
                        sizeof(uint32_t)))
        return 0;
    for (uint32_t i = 0; i < part->built.node_count; i++) {
        struct mlrt_node node = *mlrt_node_at(part, i);
        if (mlrt_node_is_leaf(&node))
            node.u.offset += whole->built.entry_count;
        else
            node.word += shift << 2;
        *mlrt_node_at(whole, i == 0 ? part->cell.node : shift + i) = node;
    }
    if (part->built.entry_count > 0)
        memcpy(mlrt_entry_at(whole, whole->built.entry_count), mlrt_entry_at(part, 0),
               part->built.entry_count * sizeof(uint32_t));
    whole->built.node_count += part->built.node_count - 1;
    whole->built.entry_count += part->built.entry_count;
    whole->built.retracted_count += part->built.retracted_count;
    release_part(whole->build, part);
    return 1;
}

/* Appends a part, and all that was cut from it, to the whole tree, which is part 0. Returns 0 if there is no memory. */
static int join_parts(struct mlrt_kdtree_part *whole, struct mlrt_kdtree_part *part)
{
    if (part->lower == 0) return part == whole || append_part(whole, part);
    struct mlrt_kdtree_part *lower = mlrt_part_at(part->build, part->lower), *upper = lower + 1;
    const uint32_t offset = whole->built.entry_count;
    if (!mlrt_add_children(whole, part->cell.node, &part->split, &lower->cell.node)) return 0;
    upper->cell.node = lower->cell.node + 1;
    return join_parts(whole, lower) && join_parts(whole, upper) &&
           mlrt_close_cell(whole, &part->cell, &lower->cell, &upper->cell, offset);
}

/* Makes a reference for each triangle that can be hit and returns their number. Counts the other triangles. */
static size_t make_references(struct mlrt_kdtree_part *root, struct mlrt_tree *tree)
{
    size_t count = 0;
    for (uint32_t i = 0; i < tree->triangle_count && !mlrt_is_cancelled_in_round(root->build->progress, i + 1); i++) {
        if (!mlrt_keep_triangle(&tree->triangles[i], &tree->info.non_finite_count, &tree->info.zero_area_count))
            continue;
        struct mlrt_reference *reference = mlrt_reference_at(root, count++);
        reference->triangle = i;
        mlrt_bound_triangle(&tree->triangles[i], reference->box.lo, reference->box.hi);
    }
    return count;
}

/* Moves bounds of a magnitude below `tiny` outward to 0 or +-tiny. */
static void round_tiny(struct mlrt_box *box, float tiny)
{
    for (int k = 0; k < 3; k++) {
        if (fabsf(box->lo[k]) < tiny) box->lo[k] = box->lo[k] < 0 ? -tiny : 0.0f;
        if (fabsf(box->hi[k]) < tiny) box->hi[k] = box->hi[k] > 0 ? tiny : 0.0f;
    }
}

/*
 * Makes the tree float-safe (scene/tree.h) if the scene's bounds are. Then no coordinate is too large, and those too
 * close to 0 are rounded outward, here and after each clipping. They stay within the scene's bounds, which are 0 or at
 * least `tiny` in magnitude.
 */
static void make_safe(struct mlrt_kdtree_part *root)
{
    struct mlrt_kdtree_build *build = root->build;
    for (int k = 0; k < 3; k++)
        if (!mlrt_is_float_safe(root->cell.box.lo[k]) || !mlrt_is_float_safe(root->cell.box.hi[k])) return;
    build->tiny = MLRT_SAFE_MIN;
    for (size_t i = 0; i < root->cell.count && !mlrt_is_cancelled_in_round(build->progress, i + 1); i++)
        round_tiny(&mlrt_reference_at(root, i)->box, build->tiny);
}

/* Makes part 0, whose root is the whole scene. Returns 0 if there is no memory, or the call is cancelled. */
static int make_root(struct mlrt_kdtree_build *build, struct mlrt_tree *tree)
{
    if (!mlrt_set_room(build, &build->parts.all, 1, sizeof(struct mlrt_kdtree_part))) return 0;
    struct mlrt_kdtree_part *root = mlrt_part_at(build, 0);
    memset(root, 0, sizeof *root);
    root->build = build;
    build->parts.count = 1;
    struct mlrt_kdtree_cell *cell = &root->cell;
    if (!mlrt_make_room(build, &root->built.references, tree->triangle_count, sizeof(struct mlrt_reference))) return 0;
    cell->count = make_references(root, tree);
    cell->work = MLRT_KDTREE_WORK * tree->triangle_count;
    cell->reference_limit = build->settings.reference_limit;
    if (cell->reference_limit < cell->count) cell->reference_limit = cell->count;
    if (cell->count > 0)
        cell->box = mlrt_measure_content(&cell->box, mlrt_reference_at(root, 0), cell->count, build->progress).bounds;
    tree->bounds = cell->box;
    make_safe(root);
    build->scene_area = mlrt_half_area(&cell->box);
    return !mlrt_is_cancelled(build->progress);
}

/* Joins the parts. Returns 0 if there is no memory. */
static int join_all(struct mlrt_kdtree_build *build)
{
    struct mlrt_kdtree_part *whole = mlrt_part_at(build, 0);
    if (whole->lower != 0) {
        whole->built.node_count = 1;
        if (!mlrt_make_room(build, &whole->built.nodes, 1, sizeof(struct mlrt_node))) return 0;
    }
    return join_parts(whole, whole) &&
           mlrt_set_room(build, &whole->built.nodes, whole->built.node_count, sizeof(struct mlrt_node)) &&
           mlrt_set_room(build, &whole->built.entries, whole->built.entry_count, sizeof(uint32_t));
}

static void release_all(struct mlrt_kdtree_build *build)
{
    for (uint32_t i = 0; i < build->parts.count; i++) release_part(build, mlrt_part_at(build, i));
    mlrt_release_room(build, &build->parts.all, sizeof(struct mlrt_kdtree_part));
}

static void take_result(struct mlrt_kdtree_part *whole, struct mlrt_tree *tree)
{
    tree->kdtree.nodes = whole->built.nodes.elements;
    tree->kdtree.node_count = whole->built.node_count;
    tree->kdtree.references = whole->built.entries.elements;
    tree->kdtree.reference_count = whole->built.entry_count;
    tree->info.retracted_count = whole->built.retracted_count;
    whole->built.nodes = whole->built.entries = (struct mlrt_growing_array){NULL, 0};
}

int32_t mlrt_build_nodes(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress)
{
    struct mlrt_kdtree_build build;
    memset(&build, 0, sizeof build);
    build.memory = &tree->memory;
    build.triangles = tree->triangles;
    build.progress = progress;
    build.settings = resolve_options(options, tree->triangle_count);
    build.parts.size = tree->triangle_count / PART_SHARE > PART_SIZE ? tree->triangle_count / PART_SHARE : PART_SIZE;
    if (tree->triangle_count > COUNT_LIMIT) return MLRT_ERROR_TOO_LARGE;
    pthread_mutex_init(&build.memory_mutex, NULL);
    const int built = make_root(&build, tree) && build_parts(&build) && join_all(&build);
    if (built) take_result(mlrt_part_at(&build, 0), tree);
    release_all(&build);
    pthread_mutex_destroy(&build.memory_mutex);
    if (!built) return mlrt_is_cancelled(progress) ? MLRT_ERROR_CANCELLED : MLRT_ERROR_OUT_OF_MEMORY;
    mlrt_measure_tree(tree, build.settings.preset.model.traversal, build.settings.preset.model.intersection, progress);
    return mlrt_is_cancelled(progress) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

/* ---- expected memory ----------------------------------------------------------------------------------------- */

/*
 * The nodes and entries of scenes take 9 to 59 bytes per triangle (docs/data/reproduce-5.md), and twice that while they
 * are built. Entries are limited; each has 4 bytes and, if it is alone in its leaf, 16 bytes of nodes.
 */
struct mlrt_demand mlrt_foresee_nodes(const void *options, uint32_t triangle_count)
{
    const struct mlrt_kdtree_settings settings = resolve_options(options, triangle_count);
    const uint64_t guess = 56 * (uint64_t)triangle_count + 64 * 12;
    const uint64_t most = 4 * settings.reference_limit + 16 * (settings.reference_limit + 1);
    const uint64_t held = guess < most ? guess : most;
    const uint64_t triangles = (uint64_t)triangle_count * sizeof(struct mlrt_triangle);
    return (struct mlrt_demand){triangles + held, 2 * triangles + 2 * held};
}
