/* SPDX-License-Identifier: MIT */
/*
 * The recursion that builds a kd-tree: ask split.c for a plane, partition the references by it, build both children,
 * and keep the subtree only if it pays. In memory are only the references of the current cell and of the siblings that
 * wait.
 *
 * The subtree of a cell depends only on its references, its box and its shares of the limits on depth, references and
 * bad splits. So subtrees are independent of each other.
 *
 * Based on: Alexander Reshetov, Alexei Soupikov, Jim Hurley, "Multi-Level Ray Tracing Algorithm", 2005, section 3.1.
 * Wenzel Jakob, Mitsuba renderer, 2010 (bad refinements and retraction).
 */
#include "mlrta/build.h"

#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "exact/predicate.h"
#include "mlrta/check.h"
#include "mlrta/kdtree.h"
#include "mlrta/split.h"
#include "scene/clip.h"

/* ---- settings ------------------------------------------------------------------------------------------------ */

struct preset {
    struct mlrt_cost_model model;
    double minimum_cell; /* rule 3: cells of less than this part of the scene's surface area are not split */
};

/*
 * Measured per 4x4 packet that starts at the root, at 1024 x 1024, as cells / triangle tests.
 *
 * Intersection cost 1, 1.5, 2.5, 4, 8: erw6 21.5 / 2.4, 21.9 / 2.2, 22.1 / 2.0, 22.3 / 2.0, 22.4 / 1.9; conference
 * 55.9 / 5.2, 56.9 / 4.7, 58.3 / 4.1, 58.8 / 4.0, 59.6 / 3.8; with 3.2, 4.4, 6.1, 7.4, 8.7 nodes per triangle. So
 * leaves that are smaller than those of 2.5 do not pay.
 *
 * Empty factor: expected costs for 1, 0.9, 0.8, 0.7 differ by less than 1 %.
 *
 * Minimum cell 1e-8, 1e-6, 2e-5, 1e-4, with preset `paper` and method packet4 (which skips a triangle that it tested in
 * a leaf just before, and triangles whose outlines its rays do not overlap): conference 64.8 / 6.7, 59.6 / 6.2,
 * 56.9 / 6.3, 55.0 / 6.9; a ship seen from inside (cruiser) 84.6 / 10.0, 75.0 / 8.5, 71.9 / 8.6, 69.4 / 9.9; a dense
 * scan (dragon, 7.8 M triangles) 333 / 51, 146 / 51, 42.9 / 43, 30.4 / 37. Build times fall by a third at each step.
 * But leaves grow, and frame times follow neither count: frames of cruiser take 169, 220, 432 ms at 1e-6, 4e-6, 2e-5,
 * those of the dragon 969, 749, 694 ms. So 1e-6 is a compromise. At 2e-5 the dragon's cells match those that the paper
 * counts for its own dragon without beams, 42.2.
 */
static const struct preset PRESETS[] = {
    {{1.0, 2.5, 0.9}, 2e-5}, /* MLRT_KDTREE_PAPER */
    {{1.0, 1.0, 0.9}, 1e-6}, /* MLRT_KDTREE_TUNED */
};

/*
 * A path may have this many bad splits, which do not pay by themselves, in the hope that splits below them do;
 * retraction removes subtrees that do not pay in the end. In cells of fewer references than the minimum, bad splits
 * hardly ever help: without the minimum, trees had at most 0.05 % lower costs and took 30 to 40 % longer to build
 * (erw6, conference, dragon). Without bad splits, costs were up to 0.7 % higher.
 */
#define BAD_REFINEMENT_LIMIT   3
#define BAD_REFINEMENT_MINIMUM 8

/*
 * In cells of more references than this, the search for a plane begins with bins. With 512, 2048, 16384, 131072 the
 * expected cost of dragon is 39.85, 39.81, 39.82, 39.84, that of conference 27.12, 27.13, 27.12, 27.07, and dragon took
 * 2.2, 2.0, 2.15, 2.3 s to build.
 */
#define BINNING_THRESHOLD 2048

/* A leaf's entry count and a child's node number have 30 bits. */
#define COUNT_LIMIT 0x3FFFFFFFu

/* The build checks for cancellation at each leaf, and before it splits a cell of at least this many references. */
#define CHECKED_SIZE 256

struct settings {
    struct preset preset;
    uint32_t rules_off;
    uint32_t depth_limit;
    uint64_t reference_limit;
};

/*
 * The usual 8 + 1.3 log2 n, plus 12 levels for empty sides and covered planes. With 60 levels in its place, expected
 * costs are the same in four digits (erw6, conference, cruiser, dragon, 2 million triangles of rooms). With 36 levels
 * they are at most 0.4 % higher, with 32 up to 4 %, with 28 up to 31 % (examples/depth.c).
 */
static uint32_t default_depth(uint32_t triangle_count)
{
    double depth = 20 + 1.3 * log2((double)triangle_count + 1);
    return depth < MLRT_DEPTH_LIMIT ? (uint32_t)depth : MLRT_DEPTH_LIMIT;
}

static struct settings resolve_options(const mlrt_kdtree_options *options, uint32_t triangle_count)
{
    static const mlrt_kdtree_options DEFAULTS;
    if (options == NULL) options = &DEFAULTS;
    struct settings settings = {PRESETS[options->preset], options->rules_off, options->max_depth,
                                options->max_references};
    if (options->traversal_cost > 0) settings.preset.model.traversal = options->traversal_cost;
    if (options->intersection_cost > 0) settings.preset.model.intersection = options->intersection_cost;
    if (settings.depth_limit == 0) settings.depth_limit = default_depth(triangle_count);
    if (settings.depth_limit > MLRT_DEPTH_LIMIT) settings.depth_limit = MLRT_DEPTH_LIMIT;
    if (settings.reference_limit == 0) settings.reference_limit = 8 * (uint64_t)triangle_count + 1024;
    if (settings.reference_limit > UINT32_MAX) settings.reference_limit = UINT32_MAX;
    return settings;
}

/* ---- growing arrays ------------------------------------------------------------------------------------------ */

struct array {
    void *elements;
    size_t capacity;
};

/* Makes room for `needed` elements of `size` bytes and keeps the contents. Returns 0 if there is no memory. */
static int reserve(struct mlrt_memory *memory, struct array *array, size_t needed, size_t size)
{
    if (needed <= array->capacity) return 1;
    size_t capacity = array->capacity + array->capacity / 2;
    if (capacity < needed) capacity = needed;
    void *elements = mlrt_resize(memory, array->elements, array->capacity, capacity, size);
    if (elements == NULL) return 0;
    array->elements = elements;
    array->capacity = capacity;
    return 1;
}

/* Likewise, but the contents are lost. */
static int reserve_scratch(struct mlrt_memory *memory, struct array *array, size_t needed, size_t size)
{
    if (needed <= array->capacity) return 1;
    mlrt_free(memory, array->elements, array->capacity, size);
    array->capacity = 0;
    array->elements = mlrt_allocate(memory, needed, size);
    if (array->elements == NULL) return 0;
    array->capacity = needed;
    return 1;
}

static void release(struct mlrt_memory *memory, struct array *array, size_t size)
{
    mlrt_free(memory, array->elements, array->capacity, size);
    array->elements = NULL;
    array->capacity = 0;
}

/* Gives back the memory past `count` elements. Returns 0 if there is no memory. */
static int trim(struct mlrt_memory *memory, struct array *array, size_t count, size_t size)
{
    void *elements = mlrt_resize(memory, array->elements, array->capacity, count, size);
    if (elements == NULL) return 0;
    array->elements = elements;
    array->capacity = count;
    return 1;
}

/* ---- one build ----------------------------------------------------------------------------------------------- */

struct build {
    struct mlrt_memory *memory;
    const struct mlrt_triangle *triangles;
    struct settings settings;
    double scene_area;
    float tiny;           /* as in mlrt_clip_halves */
    struct array pending; /* struct mlrt_reference: those of the siblings that wait, then those of the current cell */
    struct array keys;    /* uint32_t */
    struct array areas;   /* double */
    struct array nodes;   /* struct mlrt_node */
    struct array entries; /* uint32_t */
    uint32_t node_count;
    uint32_t entry_count;
    uint64_t retracted_count;
    struct mlrt_progress *progress;
};

/* A cell to be built. Its references are the pending ones from `first` to `first + count`, the last of all. */
struct cell {
    struct mlrt_box box;
    uint32_t node;
    uint32_t depth;
    uint32_t bad_refinement_count;
    size_t first;
    size_t count;
    uint64_t reference_limit; /* entries that the leaves of this cell may have in all; at least `count` */
    double work;              /* its share of the progress of the build */
};

static struct mlrt_reference *pending_at(const struct build *build, size_t index)
{
    return (struct mlrt_reference *)build->pending.elements + index;
}

static struct mlrt_node *node_at(const struct build *build, uint32_t index)
{
    return (struct mlrt_node *)build->nodes.elements + index;
}

static uint32_t *entry_at(const struct build *build, uint32_t index)
{
    return (uint32_t *)build->entries.elements + index;
}

static int rule_is_on(const struct build *build, uint32_t rule)
{
    return (build->settings.rules_off & rule) == 0;
}

static void release_work(struct build *build)
{
    release(build->memory, &build->pending, sizeof(struct mlrt_reference));
    release(build->memory, &build->keys, sizeof(uint32_t));
    release(build->memory, &build->areas, sizeof(double));
}

static void release_results(struct build *build)
{
    release(build->memory, &build->nodes, sizeof(struct mlrt_node));
    release(build->memory, &build->entries, sizeof(uint32_t));
}

/* ---- leaves -------------------------------------------------------------------------------------------------- */

static void set_leaf(struct build *build, uint32_t node, uint32_t offset, uint32_t count)
{
    node_at(build, node)->u.offset = offset;
    node_at(build, node)->word = count << 2 | 3;
}

static double leaf_cost(const struct build *build, size_t count)
{
    return build->settings.preset.model.intersection * (double)count;
}

/* Makes the cell a leaf. Returns 0 if there is no memory, or the call is cancelled. */
static int emit_leaf(struct build *build, const struct cell *cell, double *cost)
{
    uint32_t offset = build->entry_count, count = (uint32_t)cell->count;
    if (!reserve(build->memory, &build->entries, (size_t)offset + count, sizeof(uint32_t)) ||
        !reserve_scratch(build->memory, &build->keys, count, sizeof(uint32_t)))
        return 0;
    for (uint32_t i = 0; i < count; i++) *entry_at(build, offset + i) = pending_at(build, cell->first + i)->triangle;
    mlrt_sort_keys(entry_at(build, offset), build->keys.elements, count);
    build->entry_count += count;
    set_leaf(build, cell->node, offset, count);
    *cost = leaf_cost(build, count);
    return !mlrt_advance(build->progress, cell->work);
}

/* Replaces the subtree of a cell by one leaf. The entries of the subtree are those from `offset` on. */
static int retract(struct build *build, const struct cell *cell, uint32_t offset, uint32_t first_child, double *cost)
{
    uint32_t count = build->entry_count - offset;
    if (!reserve_scratch(build->memory, &build->keys, count, sizeof(uint32_t))) return 0;
    uint32_t *entries = entry_at(build, offset);
    mlrt_sort_keys(entries, build->keys.elements, count);
    uint32_t unique_count = 0;
    for (uint32_t i = 0; i < count; i++)
        if (unique_count == 0 || entries[unique_count - 1] != entries[i]) entries[unique_count++] = entries[i];
    build->entry_count = offset + unique_count;
    build->node_count = first_child;
    build->retracted_count++;
    set_leaf(build, cell->node, offset, unique_count);
    *cost = leaf_cost(build, unique_count);
    return 1;
}

/* ---- splits -------------------------------------------------------------------------------------------------- */

struct side_counts {
    size_t below;
    size_t above;
    size_t both;
};

static struct side_counts count_sides(const struct build *build, const struct cell *cell,
                                      const struct mlrt_split *split)
{
    size_t counts[3] = {0, 0, 0};
    const struct mlrt_reference *references = pending_at(build, cell->first);
    for (size_t i = 0; i < cell->count && !mlrt_is_cancelled_in_round(build->progress, i + 1); i++)
        counts[mlrt_side_of_split(&references[i], split) + 1]++;
    struct side_counts sides = {counts[0], counts[2], counts[1]};
    return sides;
}

enum choice { CHOICE_FAILED, CHOICE_LEAF, CHOICE_SPLIT };

/*
 * Rule 2, unless the plane cuts so many other triangles that the split would cost more than a leaf even if steps were
 * free. With this condition, expected costs fell by 3 % on conference and did not change on erw6. It would be too
 * strict to demand that the split pays with its step included: then walls of rooms are not split off, which takes one
 * step for each (erw6: 13 %).
 */
static enum choice try_covered_plane(struct build *build, const struct cell *cell, const struct mlrt_content *content,
                                     struct mlrt_split *split)
{
    if (!mlrt_may_be_covered(&cell->box, content)) return CHOICE_LEAF;
    if (!reserve_scratch(build->memory, &build->keys, 2 * cell->count, sizeof(uint32_t)) ||
        !reserve_scratch(build->memory, &build->areas, cell->count, sizeof(double)))
        return CHOICE_FAILED;
    if (!mlrt_find_covered_plane(build->triangles, &cell->box, pending_at(build, cell->first), cell->count, content,
                                 build->progress, build->keys.elements, build->areas.elements, split))
        return CHOICE_LEAF;
    struct side_counts sides = count_sides(build, cell, split);
    split->cost = mlrt_split_cost(&build->settings.preset.model, &cell->box, split, sides.below + sides.both,
                                  sides.above + sides.both);
    double limit = leaf_cost(build, cell->count) + build->settings.preset.model.traversal;
    return split->cost < limit ? CHOICE_SPLIT : CHOICE_LEAF;
}

/* The cheapest split, if it pays or the cell may have another bad split. */
static enum choice try_cheapest_split(struct build *build, struct cell *cell, const struct mlrt_content *content,
                                      struct mlrt_split *split)
{
    const struct preset *preset = &build->settings.preset;
    if (!reserve_scratch(build->memory, &build->keys, 3 * cell->count, sizeof(uint32_t))) return CHOICE_FAILED;
    const struct mlrt_reference *references = pending_at(build, cell->first);
    if (cell->count > BINNING_THRESHOLD)
        mlrt_find_binned_split(&preset->model, &cell->box, references, cell->count, &content->bounds, build->progress,
                               build->keys.elements, split);
    else
        mlrt_find_exact_split(&preset->model, &cell->box, references, cell->count, build->keys.elements, split);
    if (split->cost == HUGE_VAL) return CHOICE_LEAF;
    if (split->cost < leaf_cost(build, cell->count)) return CHOICE_SPLIT;
    int may_be_bad = cell->count >= BAD_REFINEMENT_MINIMUM && cell->bad_refinement_count++ < BAD_REFINEMENT_LIMIT;
    return may_be_bad ? CHOICE_SPLIT : CHOICE_LEAF;
}

static enum choice choose_split(struct build *build, struct cell *cell, struct mlrt_split *split)
{
    double area = mlrt_half_area(&cell->box);
    if (cell->count == 0 || cell->depth >= build->settings.depth_limit || area <= 0 ||
        build->node_count > COUNT_LIMIT - 2)
        return CHOICE_LEAF;
    if (rule_is_on(build, MLRT_RULE_MINIMUM_CELL) && area < build->settings.preset.minimum_cell * build->scene_area)
        return CHOICE_LEAF;
    struct mlrt_content content = mlrt_measure_content(pending_at(build, cell->first), cell->count, build->progress);
    if (rule_is_on(build, MLRT_RULE_EMPTY_SPACE) && mlrt_find_empty_side(&cell->box, &content.bounds, split))
        return CHOICE_SPLIT;
    if (rule_is_on(build, MLRT_RULE_COPLANAR)) {
        enum choice choice = try_covered_plane(build, cell, &content, split);
        if (choice != CHOICE_LEAF) return choice;
    }
    return try_cheapest_split(build, cell, &content, split);
}

/* ---- partition ----------------------------------------------------------------------------------------------- */

/* Bounds a triangle on both sides of a plane that cuts its box. */
static void bound_halves(const struct build *build, const struct mlrt_reference *reference,
                         const struct mlrt_split *split, struct mlrt_halves *halves)
{
    if (rule_is_on(build, MLRT_RULE_CLIPPED_SPLITS)) {
        mlrt_clip_halves(&build->triangles[reference->triangle], &reference->box, split->axis, split->position,
                         build->tiny, halves);
        return;
    }
    for (int side = 0; side < 2; side++) {
        halves->box[side] = reference->box;
        halves->touched[side] = 1;
    }
    halves->box[0].hi[split->axis] = split->position;
    halves->box[1].lo[split->axis] = split->position;
}

/*
 * Partitions the references of a cell: first those of the upper side, behind them those of the lower side, which is
 * built first. A triangle on both sides gets a reference in each; there is room for them behind the cell's references.
 * A triangle that, clipped to the cell, touches neither side is dropped. Sets the counts of both sides.
 *
 * In the loop [0, next) is above, [next, back) is not yet partitioned, and [back, end) is below.
 */
static void partition(struct build *build, const struct cell *cell, const struct mlrt_split *split, size_t *below_count,
                      size_t *above_count)
{
    struct mlrt_reference *references = pending_at(build, cell->first);
    size_t next = 0, back = cell->count, end = cell->count;
    while (next < back) {
        if (mlrt_is_cancelled_in_round(build->progress, back - next)) break;
        struct mlrt_reference reference = references[next];
        int side = mlrt_side_of_split(&reference, split);
        struct mlrt_halves halves;
        if (side == 0) {
            bound_halves(build, &reference, split, &halves);
            if (halves.touched[0] && halves.touched[1]) {
                references[end].triangle = reference.triangle;
                references[end++].box = halves.box[0];
                references[next++].box = halves.box[1];
                continue;
            }
            if (!halves.touched[0] && !halves.touched[1]) {
                references[next] = references[--back];
                references[back] = references[--end];
                continue;
            }
            side = halves.touched[1] ? 1 : -1;
            reference.box = halves.box[halves.touched[1]];
        }
        if (side > 0) {
            references[next++] = reference;
        } else {
            references[next] = references[--back];
            references[back] = reference;
        }
    }
    *above_count = back;
    *below_count = end - back;
}

/* ---- recursion ----------------------------------------------------------------------------------------------- */

static int build_cell(struct build *build, struct cell *cell, double *cost);

/*
 * 1 if the call is cancelled, so that a loop over the cell's references may have ended early. Its counts are then too
 * low, and memory reserved by them too small.
 */
static int is_cancelled_at(const struct build *build, const struct cell *cell)
{
    return cell->count >= MLRT_ROUNDS && mlrt_is_cancelled(build->progress);
}

static int add_children(struct build *build, uint32_t node, const struct mlrt_split *split, uint32_t *first_child)
{
    if (!reserve(build->memory, &build->nodes, (size_t)build->node_count + 2, sizeof(struct mlrt_node))) return 0;
    *first_child = build->node_count;
    build->node_count += 2;
    node_at(build, node)->u.split = split->position;
    node_at(build, node)->word = *first_child << 2 | split->axis;
    return 1;
}

/* The part of `spare` entries that a child of `count` references gets: in proportion to the counts of both children. */
static uint64_t share_of(uint64_t spare, size_t count, size_t other_count)
{
    return count == 0 ? 0 : (uint64_t)((double)spare * ((double)count / ((double)count + (double)other_count)));
}

static int build_children(struct build *build, const struct cell *cell, const struct mlrt_split *split,
                          uint32_t first_child, double *cost)
{
    struct cell below = *cell, above = *cell;
    partition(build, cell, split, &below.count, &above.count);
    if (is_cancelled_at(build, cell)) return 0;
    below.box.hi[split->axis] = split->position;
    above.box.lo[split->axis] = split->position;
    below.node = first_child;
    above.node = first_child + 1;
    below.depth = above.depth = cell->depth + 1;
    below.first = cell->first + above.count;
    uint64_t spare = cell->reference_limit - below.count - above.count;
    below.reference_limit = below.count + share_of(spare, below.count, above.count);
    above.reference_limit = cell->reference_limit - below.reference_limit;
    const size_t both = below.count + above.count;
    below.work = both > 0 ? cell->work * ((double)below.count / (double)both) : 0;
    above.work = cell->work - below.work;
    double area = mlrt_half_area(&cell->box), below_area = mlrt_half_area(&below.box),
           above_area = mlrt_half_area(&above.box), below_cost, above_cost;
    if (!build_cell(build, &below, &below_cost) || !build_cell(build, &above, &above_cost)) return 0;
    *cost = build->settings.preset.model.traversal + (below_area * below_cost + above_area * above_cost) / area;
    return 1;
}

/*
 * Builds the subtree of a cell and overwrites its references. *cost receives the expected cost of a ray through the
 * cell. Returns 0 if there is no memory, or the call is cancelled.
 */
static int build_cell(struct build *build, struct cell *cell, double *cost)
{
    struct mlrt_split split;
    if (cell->count >= CHECKED_SIZE && mlrt_is_cancelled(build->progress)) return 0;
    enum choice choice = choose_split(build, cell, &split);
    if (choice == CHOICE_FAILED) return 0;
    if (is_cancelled_at(build, cell)) return 0;
    if (choice == CHOICE_LEAF) return emit_leaf(build, cell, cost);
    struct side_counts sides = count_sides(build, cell, &split);
    if (is_cancelled_at(build, cell)) return 0;
    if (sides.both > cell->reference_limit - cell->count) return emit_leaf(build, cell, cost);
    uint32_t first_child, offset = build->entry_count;
    if (!reserve(build->memory, &build->pending, cell->first + cell->count + sides.both,
                 sizeof(struct mlrt_reference)) ||
        !add_children(build, cell->node, &split, &first_child) ||
        !build_children(build, cell, &split, first_child, cost))
        return 0;
    if (rule_is_on(build, MLRT_RULE_RETRACTION) && *cost >= leaf_cost(build, cell->count))
        return retract(build, cell, offset, first_child, cost);
    return 1;
}

/* ---- the whole tree ------------------------------------------------------------------------------------------ */

/* Adding 0 turns -0 into 0. */
static struct mlrt_box triangle_bounds(const struct mlrt_triangle *triangle)
{
    struct mlrt_box box;
    for (int k = 0; k < 3; k++) {
        float a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        float lo = a < b ? a : b, hi = a < b ? b : a;
        box.lo[k] = (c < lo ? c : lo) + 0.0f;
        box.hi[k] = (c > hi ? c : hi) + 0.0f;
    }
    return box;
}

/* Makes a reference for each triangle that can be hit and returns their number. Counts the other triangles. */
static size_t make_references(struct build *build, struct mlrt_tree *tree)
{
    size_t count = 0;
    for (uint32_t i = 0; i < tree->triangle_count && !mlrt_is_cancelled_in_round(build->progress, i + 1); i++) {
        const struct mlrt_triangle *triangle = &tree->triangles[i];
        if (!mlrt_triangle_is_finite(triangle)) {
            tree->info.non_finite_count++;
        } else if (!mlrt_triangle_has_area(triangle)) {
            tree->info.zero_area_count++;
        } else {
            pending_at(build, count)->triangle = i;
            pending_at(build, count)->box = triangle_bounds(triangle);
            count++;
        }
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
static void make_safe(struct build *build, const struct mlrt_box *bounds, size_t count)
{
    for (int k = 0; k < 3; k++)
        if (!mlrt_is_float_safe(bounds->lo[k]) || !mlrt_is_float_safe(bounds->hi[k])) return;
    build->tiny = MLRT_SAFE_MIN;
    for (size_t i = 0; i < count && !mlrt_is_cancelled_in_round(build->progress, i + 1); i++)
        round_tiny(&pending_at(build, i)->box, build->tiny);
}

static int build_tree(struct build *build, struct mlrt_tree *tree)
{
    static const struct mlrt_box NOWHERE;
    struct cell root = {NOWHERE, 0, 0, 0, 0, 0, build->settings.reference_limit, MLRT_KDTREE_WORK};
    double cost;
    if (!reserve(build->memory, &build->pending, (size_t)tree->triangle_count, sizeof(struct mlrt_reference)) ||
        !reserve(build->memory, &build->nodes, 64, sizeof(struct mlrt_node)) ||
        !reserve(build->memory, &build->entries, 64, sizeof(uint32_t)))
        return 0;
    build->node_count = 1;
    root.count = make_references(build, tree);
    root.work *= tree->triangle_count;
    if (root.count > 0) root.box = mlrt_measure_content(pending_at(build, 0), root.count, build->progress).bounds;
    if (root.reference_limit < root.count) root.reference_limit = root.count;
    tree->bounds = root.box;
    make_safe(build, &root.box, root.count);
    build->scene_area = mlrt_half_area(&root.box);
    if (is_cancelled_at(build, &root)) return 0;
    return build_cell(build, &root, &cost);
}

int32_t mlrt_build_nodes(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress)
{
    static const struct build NOTHING_BUILT;
    struct build build = NOTHING_BUILT;
    build.memory = &tree->memory;
    build.triangles = tree->triangles;
    build.progress = progress;
    build.settings = resolve_options(options, tree->triangle_count);
    tree->kdtree.nodes = NULL;
    tree->kdtree.references = NULL;
    tree->info.non_finite_count = 0;
    tree->info.zero_area_count = 0;
    if (tree->triangle_count > COUNT_LIMIT) return MLRT_ERROR_TOO_LARGE;
    int built = build_tree(&build, tree);
    release_work(&build);
    if (!built || !trim(build.memory, &build.nodes, build.node_count, sizeof(struct mlrt_node)) ||
        !trim(build.memory, &build.entries, build.entry_count, sizeof(uint32_t))) {
        release_results(&build);
        return mlrt_is_cancelled(progress) ? MLRT_ERROR_CANCELLED : MLRT_ERROR_OUT_OF_MEMORY;
    }
    tree->kdtree.nodes = build.nodes.elements;
    tree->kdtree.node_count = build.node_count;
    tree->kdtree.references = build.entries.elements;
    tree->kdtree.reference_count = build.entry_count;
    tree->info.retracted_count = build.retracted_count;
    tree->info.peak_memory_size = tree->memory.peak_size;
    mlrt_measure_tree(tree, build.settings.preset.model.traversal, build.settings.preset.model.intersection, progress);
    return mlrt_is_cancelled(progress) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

/*
 * The nodes and entries of scenes take 24 to 54 bytes per triangle, and twice that while they are built. Entries are
 * limited; each has 4 bytes and, if it is alone in its leaf, 16 bytes of nodes.
 */
struct mlrt_demand mlrt_foresee_nodes(const void *options, uint32_t triangle_count)
{
    const struct settings settings = resolve_options(options, triangle_count);
    const uint64_t guess = 56 * (uint64_t)triangle_count + 64 * 12;
    const uint64_t most = 4 * settings.reference_limit + 16 * (settings.reference_limit + 1);
    const uint64_t held = guess < most ? guess : most;
    const uint64_t triangles = (uint64_t)triangle_count * sizeof(struct mlrt_triangle);
    return (struct mlrt_demand){triangles + held, 2 * triangles + 2 * held};
}
