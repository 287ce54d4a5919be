/* SPDX-License-Identifier: MIT */
/*
 * Builds cells of the kd-tree: asks split.c for a plane, partitions the references of the cell by it, builds both
 * sides, and keeps the subtree only if it pays.
 *
 * Based on: Alexander Reshetov, Alexei Soupikov, Jim Hurley, "Multi-Level Ray Tracing Algorithm", 2005, section 3.1.
 * Wenzel Jakob, Mitsuba renderer, 2010 (bad refinements and retraction).
 */
#include "mlrta/part.h"

#include <math.h>

#include "mlrta/sort_keys.h"
#include "scene/clip.h"

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

/* The build checks for cancellation at each leaf, and before it splits a cell of at least this many references. */
#define CHECKED_SIZE 256

/*
 * Room for planes of `count` references: for as many areas, with 2 * count keys behind them, or for 3 * count keys in
 * place of both. NULL if there is no memory.
 */
static double *find_scratch(struct mlrt_kdtree_part *part, size_t count)
{
    struct mlrt_growing_array *scratch = &part->built.scratch;
    return mlrt_make_room(part->build, scratch, 2 * count + 1, sizeof(double)) ? scratch->elements : NULL;
}

/* ---- leaves -------------------------------------------------------------------------------------------------- */

static double leaf_cost(const struct mlrt_kdtree_build *build, size_t count)
{
    return build->settings.preset.model.intersection * (double)count;
}

/* Makes the cell a leaf of the part's last entries, those from `offset` on. Returns 0 if there is no memory. */
static int set_leaf(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, uint32_t offset)
{
    uint32_t count = part->built.entry_count - offset;
    void *spare = find_scratch(part, count);
    if (spare == NULL) return 0;
    count = (uint32_t)mlrt_sort_unique_keys(mlrt_entry_at(part, offset), spare, count);
    part->built.entry_count = offset + count;
    mlrt_node_at(part, cell->node)->u.offset = offset;
    mlrt_node_at(part, cell->node)->word = count << 2 | 3;
    cell->cost = leaf_cost(part->build, count);
    return 1;
}

/* Makes the cell a leaf. Returns 0 if there is no memory, or the call is cancelled. */
static int emit_leaf(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell)
{
    const uint32_t offset = part->built.entry_count, count = (uint32_t)cell->count;
    if (!mlrt_make_room(part->build, &part->built.entries, (size_t)offset + count, sizeof(uint32_t))) return 0;
    for (uint32_t i = 0; i < count; i++)
        *mlrt_entry_at(part, offset + i) = mlrt_reference_at(part, cell->first + i)->triangle;
    part->built.entry_count += count;
    return set_leaf(part, cell, offset) && !mlrt_advance(part->build->progress, cell->work);
}

/* ---- splits -------------------------------------------------------------------------------------------------- */

/* Counts the references below, on both sides of, and above the split. */
static void count_sides(const struct mlrt_kdtree_part *part, const struct mlrt_kdtree_cell *cell,
                        const struct mlrt_split *split, size_t counts[3])
{
    const struct mlrt_reference *references = mlrt_reference_at(part, cell->first);
    counts[0] = counts[1] = counts[2] = 0;
    for (size_t i = 0; i < cell->count && !mlrt_is_cancelled_in_round(part->build->progress, i + 1); i++)
        counts[mlrt_side_of_split(&references[i], split) + 1]++;
}

/*
 * Rule 2, unless the plane cuts so many other triangles that the split would cost more than a leaf even if steps were
 * free. With this condition, expected costs fell by 3 % on conference and did not change on erw6. It would be too
 * strict to demand that the split pays with its step included: then walls of rooms are not split off, which takes one
 * step for each (erw6: 13 %).
 */
static int try_covered_plane(const struct mlrt_kdtree_part *part, const struct mlrt_kdtree_cell *cell,
                             const struct mlrt_content *content, double *scratch, struct mlrt_split *split)
{
    const struct mlrt_kdtree_build *build = part->build;
    const struct mlrt_cost_model *model = &build->settings.preset.model;
    uint32_t *keys = (uint32_t *)(void *)(scratch + cell->count);
    size_t counts[3];
    if (!mlrt_find_covered_plane(build->triangles, content, keys, scratch, split)) return 0;
    count_sides(part, cell, split, counts);
    split->cost = mlrt_split_cost(model, &cell->box, split, counts[0] + counts[1], counts[1] + counts[2]);
    return split->cost < leaf_cost(build, cell->count) + model->traversal;
}

/* The cheapest split, if it pays or the cell may have another bad split. */
static int try_cheapest_split(const struct mlrt_kdtree_build *build, struct mlrt_kdtree_cell *cell,
                              const struct mlrt_content *content, uint32_t *keys, struct mlrt_split *split)
{
    const struct mlrt_cost_model *model = &build->settings.preset.model;
    (cell->count > BINNING_THRESHOLD ? mlrt_find_binned_split : mlrt_find_exact_split)(model, content, keys, split);
    if (split->cost == HUGE_VAL) return 0;
    if (split->cost < leaf_cost(build, cell->count)) return 1;
    return cell->count >= BAD_REFINEMENT_MINIMUM && cell->bad_refinement_count++ < BAD_REFINEMENT_LIMIT;
}

static enum mlrt_choice choose_split(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell,
                                     struct mlrt_split *split)
{
    const struct mlrt_kdtree_build *build = part->build;
    const double area = mlrt_half_area(&cell->box);
    if (cell->count == 0 || cell->depth >= build->settings.depth_limit || area <= 0 ||
        part->built.node_count >= part->built.node_limit)
        return MLRT_CHOICE_LEAF;
    if (mlrt_rule_is_on(build, MLRT_RULE_MINIMUM_CELL) &&
        area < build->settings.preset.minimum_cell * build->scene_area)
        return MLRT_CHOICE_LEAF;
    const struct mlrt_content content =
        mlrt_measure_content(&cell->box, mlrt_reference_at(part, cell->first), cell->count, build->progress);
    if (mlrt_rule_is_on(build, MLRT_RULE_EMPTY_SPACE) && mlrt_find_empty_side(&content, split))
        return MLRT_CHOICE_SPLIT;
    double *scratch = find_scratch(part, cell->count);
    if (scratch == NULL) return MLRT_CHOICE_FAILED;
    if (mlrt_rule_is_on(build, MLRT_RULE_COPLANAR) && try_covered_plane(part, cell, &content, scratch, split))
        return MLRT_CHOICE_SPLIT;
    return try_cheapest_split(build, cell, &content, (void *)scratch, split) ? MLRT_CHOICE_SPLIT : MLRT_CHOICE_LEAF;
}

/* ---- partition ----------------------------------------------------------------------------------------------- */

/* Bounds a triangle on both sides of a plane that cuts its box. */
static void bound_halves(const struct mlrt_kdtree_build *build, const struct mlrt_reference *reference,
                         const struct mlrt_split *split, struct mlrt_halves *halves)
{
    if (mlrt_rule_is_on(build, MLRT_RULE_CLIPPED_SPLITS)) {
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
static void partition(const struct mlrt_kdtree_part *part, const struct mlrt_kdtree_cell *cell,
                      const struct mlrt_split *split, size_t *below_count, size_t *above_count)
{
    struct mlrt_reference *references = mlrt_reference_at(part, cell->first);
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
static void deal_out(const struct mlrt_kdtree_part *part, const struct mlrt_kdtree_cell *cell,
                     const struct mlrt_split *split, struct mlrt_kdtree_cell sides[2])
{
    struct mlrt_kdtree_cell *below = &sides[0], *above = &sides[1];
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
static int is_cancelled_at(const struct mlrt_kdtree_part *part, const struct mlrt_kdtree_cell *cell)
{
    return cell->count >= MLRT_ROUNDS && mlrt_is_cancelled(part->build->progress);
}

enum mlrt_choice mlrt_cut_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, struct mlrt_split *split,
                               struct mlrt_kdtree_cell sides[2])
{
    if (cell->count >= CHECKED_SIZE) {
        const double work = cell->work / log2((double)cell->count);
        cell->work -= work;
        if (mlrt_advance(part->build->progress, work)) return MLRT_CHOICE_FAILED;
    }
    const enum mlrt_choice choice = choose_split(part, cell, split);
    if (is_cancelled_at(part, cell)) return MLRT_CHOICE_FAILED;
    if (choice != MLRT_CHOICE_SPLIT) return choice;
    size_t counts[3];
    count_sides(part, cell, split, counts);
    const size_t both = counts[1];
    if (is_cancelled_at(part, cell)) return MLRT_CHOICE_FAILED;
    if (both > cell->reference_limit - cell->count) return MLRT_CHOICE_LEAF;
    if (!mlrt_make_room(part->build, &part->built.references, cell->first + cell->count + both,
                        sizeof(struct mlrt_reference)))
        return MLRT_CHOICE_FAILED;
    deal_out(part, cell, split, sides);
    return is_cancelled_at(part, cell) ? MLRT_CHOICE_FAILED : MLRT_CHOICE_SPLIT;
}

/* ---- subtrees ------------------------------------------------------------------------------------------------ */

int mlrt_add_children(struct mlrt_kdtree_part *part, uint32_t node, const struct mlrt_split *split,
                      uint32_t *first_child)
{
    if (!mlrt_make_room(part->build, &part->built.nodes, (size_t)part->built.node_count + 2, sizeof(struct mlrt_node)))
        return 0;
    *first_child = part->built.node_count;
    part->built.node_count += 2;
    mlrt_node_at(part, node)->u.split = split->position;
    mlrt_node_at(part, node)->word = *first_child << 2 | split->axis;
    return 1;
}

int mlrt_close_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, const struct mlrt_kdtree_cell *below,
                    const struct mlrt_kdtree_cell *above, uint32_t offset)
{
    const struct mlrt_kdtree_build *build = part->build;
    const double tests = mlrt_half_area(&below->box) * below->cost + mlrt_half_area(&above->box) * above->cost;
    cell->cost = build->settings.preset.model.traversal + tests / mlrt_half_area(&cell->box);
    if (!mlrt_rule_is_on(build, MLRT_RULE_RETRACTION) || cell->cost < leaf_cost(build, cell->count)) return 1;
    part->built.node_count = below->node;
    part->built.retracted_count++;
    return set_leaf(part, cell, offset);
}

int mlrt_build_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell)
{
    struct mlrt_split split;
    struct mlrt_kdtree_cell sides[2];
    const uint32_t offset = part->built.entry_count;
    const enum mlrt_choice choice = mlrt_cut_cell(part, cell, &split, sides);
    if (choice == MLRT_CHOICE_FAILED) return 0;
    if (choice == MLRT_CHOICE_LEAF) return emit_leaf(part, cell);
    if (!mlrt_add_children(part, cell->node, &split, &sides[0].node)) return 0;
    sides[1].node = sides[0].node + 1;
    return mlrt_build_cell(part, &sides[0]) && mlrt_build_cell(part, &sides[1]) &&
           mlrt_close_cell(part, cell, &sides[0], &sides[1], offset);
}
