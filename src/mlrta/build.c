/* SPDX-License-Identifier: MIT */
/*
 * The builder of the kd-tree: asks split.c for a plane, partitions the references of the cell by it, builds both sides,
 * and keeps the subtree only if it pays.
 *
 * The subtree of a cell depends only on its references, its box and its shares of the limits on depth, references,
 * nodes and bad splits. So the workers of the pool build parts of the tree at the same time: large cells are cut in
 * two, each by one worker, round after round, until all are small; a small one is built by one worker, with the
 * references of the current cell and of the siblings that wait in memory. At the end the calling thread joins the parts
 * in depth-first order. Neither the tree nor the order of any sum depends on the number of workers.
 *
 * Based on: Alexander Reshetov, Alexei Soupikov, Jim Hurley, "Multi-Level Ray Tracing Algorithm", 2005, section 3.1.
 * Wenzel Jakob, Mitsuba renderer, 2010 (bad refinements and retraction).
 */
#include "mlrta/kdtree.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "base/platform.h"
#include "base/progress.h"
#include "base/scheduler.h"
#include "exact/predicate.h"
#include "mlrta/split.h"
#include "scene/clip.h"

/* ---- settings ------------------------------------------------------------------------------------------------ */

struct preset {
    struct mlrt_cost_model model;
    double minimum_cell; /* rule 3: cells of less than this part of the scene's surface area are not split */
};

/*
 * Intersection cost: with 1, 2.5, 8 a 4x4 packet from the root visits 55.9, 58.3, 59.6 cells of conference and tests
 * 5.2, 4.1, 3.8 triangles, by 3.2, 6.1, 8.7 nodes per triangle. So leaves that are smaller than those of 2.5 do not pay.
 *
 * Empty factor: expected costs for 1, 0.9, 0.8, 0.7 differ by less than 1 %.
 *
 * Minimum cell: with 1e-8, 1e-6, 2e-5, 1e-4, packets visit 64.8, 59.6, 56.9, 55.0 cells of conference and 333, 146,
 * 42.9, 30.4 of a dense scan (dragon, 7.8 M triangles); at 2e-5 these match the 42.2 that the paper counts for its own
 * dragon without beams. Build times fall by a third at each step. But leaves grow: frames of a ship seen from inside
 * (cruiser) take 169, 220, 432 ms at 1e-6, 4e-6, 2e-5, those of the dragon 969, 749, 694 ms. So 1e-6 is a compromise.
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

/*
 * Cells of more references than this, and than this part of the triangles, are cut into parts. `bench --study build`
 * shows what several workers gain: less than their number, as the first rounds have fewer cells than there are workers.
 */
#define PART_SIZE  2048
#define PART_SHARE 512

/*
 * The most nodes of all parts together. Above the parts there are fewer: on each of MLRT_DEPTH_LIMIT levels, cells of
 * more than PART_SIZE references with at most 2^32 of them together, which are 2^28 nodes in all.
 */
#define PART_NODE_LIMIT (COUNT_LIMIT / 2)

/* The build checks for cancellation at each leaf, and before it splits a cell of at least this many references. */
#define CHECKED_SIZE 256

struct settings {
    struct preset preset;
    uint32_t rules_off;
    uint32_t depth_limit;
    uint64_t reference_limit;
    mlrt_pool *pool;
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
                                options->max_references, options->pool};
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

/* The parts that a build is cut into. */
struct parts {
    struct array all; /* struct part */
    uint32_t count;
    uint32_t first; /* the first that the workers take in this round */
    size_t size;    /* cells of more references than this are cut into parts */
};

/* What the workers of a call share. Only one at a time allocates or frees. */
struct build {
    struct mlrt_memory *memory;
    pthread_mutex_t memory_mutex;
    const struct mlrt_triangle *triangles;
    struct settings settings;
    double scene_area;
    float tiny; /* as in mlrt_clip_halves */
    struct mlrt_progress *progress;
    struct array scratch; /* struct array of double: one for each worker, to look for planes and to sort */
    struct parts parts;
};

/* Changes the number of elements of `size` bytes and keeps the contents. Returns 0 if there is no memory. */
static int resize(struct build *build, struct array *array, size_t count, size_t size)
{
    pthread_mutex_lock(&build->memory_mutex);
    void *elements = mlrt_resize(build->memory, array->elements, array->capacity, count, size);
    pthread_mutex_unlock(&build->memory_mutex);
    if (elements == NULL) return 0;
    array->elements = elements;
    array->capacity = count;
    return 1;
}

/* Makes room for `needed` elements. Returns 0 if there is no memory. Not inlined: 240 bytes less. */
static MLRT_NOINLINE int reserve(struct build *build, struct array *array, size_t needed, size_t size)
{
    const size_t grown = array->capacity + array->capacity / 2;
    return needed <= array->capacity || resize(build, array, needed > grown ? needed : grown, size);
}

/* Not inlined: 360 bytes less. */
static MLRT_NOINLINE void release(struct build *build, struct array *array, size_t size)
{
    pthread_mutex_lock(&build->memory_mutex);
    mlrt_free(build->memory, array->elements, array->capacity, size);
    pthread_mutex_unlock(&build->memory_mutex);
    array->elements = NULL;
    array->capacity = 0;
}

/* ---- parts --------------------------------------------------------------------------------------------------- */

/* A cell to be built. Its references are those of its part from `first` to `first + count`, the last of all. */
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

/* A subtree that one worker builds. */
struct subtree {
    struct array
        references;       /* struct mlrt_reference: those of the siblings that wait, then those of the current cell */
    struct array nodes;   /* struct mlrt_node */
    struct array entries; /* uint32_t */
    uint32_t node_count;
    uint32_t node_limit;
    uint32_t entry_count;
    uint64_t retracted_count;
    double cost;
};

/* A part of the tree: a cell that is cut in two, or a subtree. All 0 = not used. */
struct part {
    struct build *build;
    struct array *scratch;   /* of the worker that works on it */
    struct cell cell;        /* of its root */
    uint32_t lower;          /* number of the part that has its lower side; the upper side has the next; 0 = not cut */
    struct mlrt_split split; /* if it is cut */
    struct subtree built;    /* if it is not */
};

static struct part *part_at(const struct build *build, uint32_t number)
{
    return (struct part *)build->parts.all.elements + number;
}

static struct mlrt_reference *reference_at(const struct part *part, size_t index)
{
    return (struct mlrt_reference *)part->built.references.elements + index;
}

static struct mlrt_node *node_at(const struct part *part, uint32_t index)
{
    return (struct mlrt_node *)part->built.nodes.elements + index;
}

static uint32_t *entry_at(const struct part *part, uint32_t index)
{
    return (uint32_t *)part->built.entries.elements + index;
}

static int rule_is_on(const struct build *build, uint32_t rule)
{
    return (build->settings.rules_off & rule) == 0;
}

/*
 * Room for planes of `count` references: for as many areas, with 2 * count keys behind them, or for 3 * count keys in
 * place of both. NULL if there is no memory.
 */
static double *get_scratch(const struct part *part, size_t count)
{
    return reserve(part->build, part->scratch, 2 * count + 1, sizeof(double)) ? part->scratch->elements : NULL;
}

/* ---- leaves -------------------------------------------------------------------------------------------------- */

static double leaf_cost(const struct build *build, size_t count)
{
    return build->settings.preset.model.intersection * (double)count;
}

/* Makes a leaf of the part's last entries, those from `offset` on. Returns 0 if there is no memory. */
static int set_leaf(struct part *part, uint32_t node, uint32_t offset, double *cost)
{
    uint32_t count = part->built.entry_count - offset;
    void *spare = get_scratch(part, count);
    if (spare == NULL) return 0;
    count = (uint32_t)mlrt_sort_unique_keys(entry_at(part, offset), spare, count);
    part->built.entry_count = offset + count;
    node_at(part, node)->u.offset = offset;
    node_at(part, node)->word = count << 2 | 3;
    *cost = leaf_cost(part->build, count);
    return 1;
}

/* Makes the cell a leaf. Returns 0 if there is no memory, or the call is cancelled. */
static int emit_leaf(struct part *part, const struct cell *cell, double *cost)
{
    const uint32_t offset = part->built.entry_count, count = (uint32_t)cell->count;
    if (!reserve(part->build, &part->built.entries, (size_t)offset + count, sizeof(uint32_t))) return 0;
    for (uint32_t i = 0; i < count; i++) *entry_at(part, offset + i) = reference_at(part, cell->first + i)->triangle;
    part->built.entry_count += count;
    return set_leaf(part, cell->node, offset, cost) && !mlrt_advance(part->build->progress, cell->work);
}

/* ---- splits -------------------------------------------------------------------------------------------------- */

/* Counts the references below, on both sides of, and above the split. */
static void count_sides(const struct part *part, const struct cell *cell, const struct mlrt_split *split,
                        size_t counts[3])
{
    const struct mlrt_reference *references = reference_at(part, cell->first);
    counts[0] = counts[1] = counts[2] = 0;
    for (size_t i = 0; i < cell->count && !mlrt_is_cancelled_in_round(part->build->progress, i + 1); i++)
        counts[mlrt_side_of_split(&references[i], split) + 1]++;
}

enum choice { CHOICE_FAILED, CHOICE_LEAF, CHOICE_SPLIT };

/*
 * Rule 2, unless the plane cuts so many other triangles that the split would cost more than a leaf even if steps were
 * free. With this condition, expected costs fell by 3 % on conference and did not change on erw6. It would be too
 * strict to demand that the split pays with its step included: then walls of rooms are not split off, which takes one
 * step for each (erw6: 13 %).
 */
static int try_covered_plane(const struct part *part, const struct cell *cell, const struct mlrt_content *content,
                             double *scratch, struct mlrt_split *split)
{
    const struct build *build = part->build;
    const struct mlrt_cost_model *model = &build->settings.preset.model;
    uint32_t *keys = (uint32_t *)(void *)(scratch + cell->count);
    size_t counts[3];
    if (!mlrt_find_covered_plane(build->triangles, content, keys, scratch, split)) return 0;
    count_sides(part, cell, split, counts);
    split->cost = mlrt_split_cost(model, &cell->box, split, counts[0] + counts[1], counts[1] + counts[2]);
    return split->cost < leaf_cost(build, cell->count) + model->traversal;
}

/* The cheapest split, if it pays or the cell may have another bad split. */
static int try_cheapest_split(const struct build *build, struct cell *cell, const struct mlrt_content *content,
                              uint32_t *keys, struct mlrt_split *split)
{
    const struct mlrt_cost_model *model = &build->settings.preset.model;
    (cell->count > BINNING_THRESHOLD ? mlrt_find_binned_split : mlrt_find_exact_split)(model, content, keys, split);
    if (split->cost == HUGE_VAL) return 0;
    if (split->cost < leaf_cost(build, cell->count)) return 1;
    return cell->count >= BAD_REFINEMENT_MINIMUM && cell->bad_refinement_count++ < BAD_REFINEMENT_LIMIT;
}

static enum choice choose_split(const struct part *part, struct cell *cell, struct mlrt_split *split)
{
    const struct build *build = part->build;
    const double area = mlrt_half_area(&cell->box);
    if (cell->count == 0 || cell->depth >= build->settings.depth_limit || area <= 0 ||
        part->built.node_count >= part->built.node_limit)
        return CHOICE_LEAF;
    if (rule_is_on(build, MLRT_RULE_MINIMUM_CELL) && area < build->settings.preset.minimum_cell * build->scene_area)
        return CHOICE_LEAF;
    const struct mlrt_content content =
        mlrt_measure_content(&cell->box, reference_at(part, cell->first), cell->count, build->progress);
    if (rule_is_on(build, MLRT_RULE_EMPTY_SPACE) && mlrt_find_empty_side(&content, split)) return CHOICE_SPLIT;
    double *scratch = get_scratch(part, cell->count);
    if (scratch == NULL) return CHOICE_FAILED;
    if (rule_is_on(build, MLRT_RULE_COPLANAR) && try_covered_plane(part, cell, &content, scratch, split))
        return CHOICE_SPLIT;
    return try_cheapest_split(build, cell, &content, (void *)scratch, split) ? CHOICE_SPLIT : CHOICE_LEAF;
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
static void partition(const struct part *part, const struct cell *cell, const struct mlrt_split *split,
                      size_t *below_count, size_t *above_count)
{
    struct mlrt_reference *references = reference_at(part, cell->first);
    size_t next = 0, back = cell->count, end = cell->count;
    while (next < back) {
        if (mlrt_is_cancelled_in_round(part->build->progress, back - next)) break;
        struct mlrt_reference reference = references[next];
        int side = mlrt_side_of_split(&reference, split);
        struct mlrt_halves halves;
        if (side == 0) {
            bound_halves(part->build, &reference, split, &halves);
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

/* The part of `spare` entries that a child of `count` references gets: in proportion to the counts of both children. */
static uint64_t share_of(uint64_t spare, size_t count, size_t other_count)
{
    return count == 0 ? 0 : (uint64_t)((double)spare * ((double)count / ((double)count + (double)other_count)));
}

/* Deals the references of a cell out to its sides. */
static void deal_out(const struct part *part, const struct cell *cell, const struct mlrt_split *split,
                     struct cell sides[2])
{
    struct cell *below = &sides[0], *above = &sides[1];
    *below = *above = *cell;
    partition(part, cell, split, &below->count, &above->count);
    below->box.hi[split->axis] = split->position;
    above->box.lo[split->axis] = split->position;
    below->depth = above->depth = cell->depth + 1;
    below->first = cell->first + above->count;
    const size_t both = below->count + above->count;
    below->reference_limit = below->count + share_of(cell->reference_limit - both, below->count, above->count);
    above->reference_limit = cell->reference_limit - below->reference_limit;
    below->work = both > 0 ? cell->work * ((double)below->count / (double)both) : 0;
    above->work = cell->work - below->work;
}

/*
 * 1 if the call is cancelled, so that a loop over the cell's references may have ended early. Its counts are then too
 * low, and memory reserved by them too small.
 */
static int is_cancelled_at(const struct part *part, const struct cell *cell)
{
    return cell->count >= MLRT_ROUNDS && mlrt_is_cancelled(part->build->progress);
}

/*
 * Cuts a cell in two: CHOICE_SPLIT. CHOICE_LEAF: it becomes a leaf. CHOICE_FAILED: there is no memory, or the call is
 * cancelled. A large cell advances the progress by the work of one of the levels below it.
 */
static enum choice cut(struct part *part, struct cell *cell, struct mlrt_split *split, struct cell sides[2])
{
    if (cell->count >= CHECKED_SIZE) {
        const double work = cell->work / log2((double)cell->count);
        cell->work -= work;
        if (mlrt_advance(part->build->progress, work)) return CHOICE_FAILED;
    }
    const enum choice choice = choose_split(part, cell, split);
    if (is_cancelled_at(part, cell)) return CHOICE_FAILED;
    if (choice != CHOICE_SPLIT) return choice;
    size_t counts[3];
    count_sides(part, cell, split, counts);
    const size_t both = counts[1];
    if (is_cancelled_at(part, cell)) return CHOICE_FAILED;
    if (both > cell->reference_limit - cell->count) return CHOICE_LEAF;
    if (!reserve(part->build, &part->built.references, cell->first + cell->count + both, sizeof(struct mlrt_reference)))
        return CHOICE_FAILED;
    deal_out(part, cell, split, sides);
    return is_cancelled_at(part, cell) ? CHOICE_FAILED : CHOICE_SPLIT;
}

/* ---- subtrees ------------------------------------------------------------------------------------------------ */

/* Adds the children of a node, and sets *first_child to the lower one. Returns 0 if there is no memory. */
static int add_children(struct part *part, uint32_t node, const struct mlrt_split *split, uint32_t *first_child)
{
    if (!reserve(part->build, &part->built.nodes, (size_t)part->built.node_count + 2, sizeof(struct mlrt_node)))
        return 0;
    *first_child = part->built.node_count;
    part->built.node_count += 2;
    node_at(part, node)->u.split = split->position;
    node_at(part, node)->word = *first_child << 2 | split->axis;
    return 1;
}

/*
 * Ends the subtree of a cell, whose sides are built at these costs: if it does not pay, one leaf replaces it. Its
 * entries are those from `offset` on. *cost receives the expected cost of a ray through the cell. Returns 0 if there is
 * no memory.
 */
static int close_cell(struct part *part, const struct cell *cell, const struct cell *below, const struct cell *above,
                      const double costs[2], uint32_t offset, double *cost)
{
    const struct build *build = part->build;
    const double tests = mlrt_half_area(&below->box) * costs[0] + mlrt_half_area(&above->box) * costs[1];
    *cost = build->settings.preset.model.traversal + tests / mlrt_half_area(&cell->box);
    if (!rule_is_on(build, MLRT_RULE_RETRACTION) || *cost < leaf_cost(build, cell->count)) return 1;
    part->built.node_count = below->node;
    part->built.retracted_count++;
    return set_leaf(part, cell->node, offset, cost);
}

/*
 * Builds the subtree of a cell and overwrites its references. *cost receives the expected cost of a ray through the
 * cell. Returns 0 if there is no memory, or the call is cancelled.
 */
static int build_cell(struct part *part, struct cell *cell, double *cost)
{
    struct mlrt_split split;
    struct cell sides[2];
    double costs[2];
    const uint32_t offset = part->built.entry_count;
    const enum choice choice = cut(part, cell, &split, sides);
    if (choice == CHOICE_FAILED) return 0;
    if (choice == CHOICE_LEAF) return emit_leaf(part, cell, cost);
    if (!add_children(part, cell->node, &split, &sides[0].node)) return 0;
    sides[1].node = sides[0].node + 1;
    for (int side = 0; side < 2; side++)
        if (!build_cell(part, &sides[side], &costs[side])) return 0;
    return close_cell(part, cell, &sides[0], &sides[1], costs, offset, cost);
}

/* ---- parts --------------------------------------------------------------------------------------------------- */

/* Builds a part with a root that is its node 0. Returns 0 if there is no memory, or the call is cancelled. */
static int build_part(struct part *part)
{
    struct build *build = part->build;
    part->built.node_count = 1;
    if (!reserve(build, &part->built.nodes, part->cell.count / 2 + 1, sizeof(struct mlrt_node)) ||
        !reserve(build, &part->built.entries, part->cell.count + 1, sizeof(uint32_t)) ||
        !build_cell(part, &part->cell, &part->built.cost))
        return 0;
    release(build, &part->built.references, sizeof(struct mlrt_reference));
    return 1;
}

/*
 * Cuts a part in two, of which the upper one keeps its array of references. Or builds it, if its root becomes a leaf.
 * Returns 0 if there is no memory, or the call is cancelled.
 */
static int cut_part(struct part *part)
{
    struct build *build = part->build;
    struct part *lower = part_at(build, part->lower), *upper = lower + 1;
    struct cell whole = part->cell, sides[2];
    const enum choice choice = cut(part, &whole, &part->split, sides);
    if (choice == CHOICE_FAILED) return 0;
    if (choice == CHOICE_LEAF) {
        part->lower = 0;
        return build_part(part);
    }
    lower->build = upper->build = build;
    lower->cell = sides[0];
    upper->cell = sides[1];
    lower->cell.first = 0;
    upper->built.references = part->built.references;
    part->built.references = (struct array){NULL, 0};
    if (!reserve(build, &lower->built.references, sides[0].count, sizeof(struct mlrt_reference))) return 0;
    if (sides[0].count > 0)
        memcpy(lower->built.references.elements, reference_at(upper, sides[0].first),
               sides[0].count * sizeof(struct mlrt_reference));
    return resize(build, &upper->built.references, sides[1].count, sizeof(struct mlrt_reference));
}

static int32_t run_part(void *work, uint32_t item, uint32_t worker)
{
    struct build *build = work;
    struct part *part = part_at(build, build->parts.first + item);
    if (part->build == NULL) return 0;
    mlrt_fp_environment environment;
    mlrt_enter_fp_environment(&environment);
    const double share = (double)part->cell.reference_limit / (double)part_at(build, 0)->cell.reference_limit;
    part->built.node_limit = (uint32_t)(PART_NODE_LIMIT * share);
    part->scratch = (struct array *)build->scratch.elements + worker;
    const int done = part->lower != 0 ? cut_part(part) : build_part(part);
    mlrt_leave_fp_environment(&environment);
    return done ? 0 : MLRT_ERROR_OUT_OF_MEMORY;
}

/*
 * Works on all parts, beginning with the one that there is. In each round the workers take those that the last round
 * made: they cut the large ones, and build the others. Returns 0 if there is no memory, or the call is cancelled.
 */
static int build_parts(struct build *build)
{
    while (build->parts.first < build->parts.count) {
        const uint32_t end = build->parts.count, count = end - build->parts.first;
        if (!reserve(build, &build->parts.all, (size_t)end + 2 * (size_t)count, sizeof(struct part))) return 0;
        memset(part_at(build, end), 0, 2 * (size_t)count * sizeof(struct part));
        for (uint32_t i = build->parts.first; i < end; i++) {
            if (part_at(build, i)->cell.count <= build->parts.size) continue;
            part_at(build, i)->lower = build->parts.count;
            build->parts.count += 2;
        }
        if (mlrt_run_items(build->settings.pool, count, run_part, build) != 0) return 0;
        build->parts.first = end;
    }
    return 1;
}

/* ---- the whole tree ------------------------------------------------------------------------------------------ */

static void release_part(struct build *build, struct part *part)
{
    release(build, &part->built.references, sizeof(struct mlrt_reference));
    release(build, &part->built.nodes, sizeof(struct mlrt_node));
    release(build, &part->built.entries, sizeof(uint32_t));
}

/*
 * Copies a part that is built into the whole tree, where part->cell.node is its root. Returns 0 if there is no memory.
 */
static int append_part(struct part *whole, struct part *part)
{
    const uint32_t shift = whole->built.node_count - 1; /* node 1 of the part is the next of the whole tree */
    if (!reserve(whole->build, &whole->built.nodes, (size_t)shift + part->built.node_count, sizeof(struct mlrt_node)) ||
        !reserve(whole->build, &whole->built.entries, (size_t)whole->built.entry_count + part->built.entry_count,
                 sizeof(uint32_t)))
        return 0;
    for (uint32_t i = 0; i < part->built.node_count; i++) {
        struct mlrt_node node = *node_at(part, i);
        if (mlrt_node_is_leaf(&node))
            node.u.offset += whole->built.entry_count;
        else
            node.word += shift << 2;
        *node_at(whole, i == 0 ? part->cell.node : shift + i) = node;
    }
    if (part->built.entry_count > 0)
        memcpy(entry_at(whole, whole->built.entry_count), entry_at(part, 0),
               part->built.entry_count * sizeof(uint32_t));
    whole->built.node_count += part->built.node_count - 1;
    whole->built.entry_count += part->built.entry_count;
    whole->built.retracted_count += part->built.retracted_count;
    release_part(whole->build, part);
    return 1;
}

/* Appends a part, and all that was cut from it, to the whole tree, which is part 0. Returns 0 if there is no memory. */
static int join_parts(struct part *whole, struct part *part)
{
    if (part->lower == 0) return part == whole || append_part(whole, part);
    struct part *lower = part_at(part->build, part->lower), *upper = lower + 1;
    const uint32_t offset = whole->built.entry_count;
    if (!add_children(whole, part->cell.node, &part->split, &lower->cell.node)) return 0;
    upper->cell.node = lower->cell.node + 1;
    if (!join_parts(whole, lower) || !join_parts(whole, upper)) return 0;
    const double costs[2] = {lower->built.cost, upper->built.cost};
    return close_cell(whole, &part->cell, &lower->cell, &upper->cell, costs, offset, &part->built.cost);
}

/* Makes a reference for each triangle that can be hit and returns their number. Counts the other triangles. */
static size_t make_references(struct part *root, struct mlrt_tree *tree)
{
    size_t count = 0;
    for (uint32_t i = 0; i < tree->triangle_count && !mlrt_is_cancelled_in_round(root->build->progress, i + 1); i++) {
        if (!mlrt_keep_triangle(&tree->triangles[i], &tree->info.non_finite_count, &tree->info.zero_area_count))
            continue;
        struct mlrt_reference *reference = reference_at(root, count++);
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
static void make_safe(struct part *root)
{
    struct build *build = root->build;
    for (int k = 0; k < 3; k++)
        if (!mlrt_is_float_safe(root->cell.box.lo[k]) || !mlrt_is_float_safe(root->cell.box.hi[k])) return;
    build->tiny = MLRT_SAFE_MIN;
    for (size_t i = 0; i < root->cell.count && !mlrt_is_cancelled_in_round(build->progress, i + 1); i++)
        round_tiny(&reference_at(root, i)->box, build->tiny);
}

/* Makes part 0, whose root is the whole scene. Returns 0 if there is no memory, or the call is cancelled. */
static int make_root(struct build *build, struct mlrt_tree *tree)
{
    const uint32_t worker_count = mlrt_worker_count(build->settings.pool);
    if (!resize(build, &build->scratch, worker_count, sizeof(struct array))) return 0;
    memset(build->scratch.elements, 0, worker_count * sizeof(struct array));
    if (!resize(build, &build->parts.all, 1, sizeof(struct part))) return 0;
    struct part *root = part_at(build, 0);
    memset(root, 0, sizeof *root);
    root->build = build;
    build->parts.count = 1;
    struct cell *cell = &root->cell;
    if (!reserve(build, &root->built.references, tree->triangle_count, sizeof(struct mlrt_reference))) return 0;
    cell->count = make_references(root, tree);
    cell->work = MLRT_KDTREE_WORK * tree->triangle_count;
    cell->reference_limit = build->settings.reference_limit;
    if (cell->reference_limit < cell->count) cell->reference_limit = cell->count;
    if (cell->count > 0)
        cell->box = mlrt_measure_content(&cell->box, reference_at(root, 0), cell->count, build->progress).bounds;
    tree->bounds = cell->box;
    make_safe(root);
    build->scene_area = mlrt_half_area(&cell->box);
    return !is_cancelled_at(root, cell);
}

/* Joins the parts. Returns 0 if there is no memory. */
static int join_all(struct build *build)
{
    struct part *whole = part_at(build, 0);
    whole->scratch = build->scratch.elements;
    if (whole->lower != 0) {
        whole->built.node_count = 1;
        if (!reserve(build, &whole->built.nodes, 1, sizeof(struct mlrt_node))) return 0;
    }
    return join_parts(whole, whole) &&
           resize(build, &whole->built.nodes, whole->built.node_count, sizeof(struct mlrt_node)) &&
           resize(build, &whole->built.entries, whole->built.entry_count, sizeof(uint32_t));
}

static void release_all(struct build *build)
{
    for (uint32_t i = 0; i < build->parts.count; i++) release_part(build, part_at(build, i));
    for (size_t i = 0; i < build->scratch.capacity; i++)
        release(build, (struct array *)build->scratch.elements + i, sizeof(double));
    release(build, &build->parts.all, sizeof(struct part));
    release(build, &build->scratch, sizeof(struct array));
}

static void take_result(struct part *whole, struct mlrt_tree *tree)
{
    tree->kdtree.nodes = whole->built.nodes.elements;
    tree->kdtree.node_count = whole->built.node_count;
    tree->kdtree.references = whole->built.entries.elements;
    tree->kdtree.reference_count = whole->built.entry_count;
    tree->info.retracted_count = whole->built.retracted_count;
    whole->built.nodes = whole->built.entries = (struct array){NULL, 0};
}

int32_t mlrt_build_nodes(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress)
{
    struct build build;
    memset(&build, 0, sizeof build);
    build.memory = &tree->memory;
    build.triangles = tree->triangles;
    build.progress = progress;
    build.settings = resolve_options(options, tree->triangle_count);
    build.parts.size = tree->triangle_count / PART_SHARE > PART_SIZE ? tree->triangle_count / PART_SHARE : PART_SIZE;
    if (tree->triangle_count > COUNT_LIMIT) return MLRT_ERROR_TOO_LARGE;
    pthread_mutex_init(&build.memory_mutex, NULL);
    const int built = make_root(&build, tree) && build_parts(&build) && join_all(&build);
    if (built) take_result(part_at(&build, 0), tree);
    release_all(&build);
    pthread_mutex_destroy(&build.memory_mutex);
    if (!built) return mlrt_is_cancelled(progress) ? MLRT_ERROR_CANCELLED : MLRT_ERROR_OUT_OF_MEMORY;
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
