/* SPDX-License-Identifier: MIT */
/*
 * Entry-point search: see entry_point.h.
 */
#include "mlrta/entry_point.h"

#include <string.h>

#include "job/job.h"
#include "mlrta/beam_culling.h"
#include "mlrta/covering.h"

/* Leaves of more triangles are not searched for a cover: there one triangle rarely covers a beam. */
#define COVER_TRIAL_LIMIT 8

/* Goes down to a child of an inner node, `child` being the lower one. */
MLRT_INLINE void enter_child(struct entry_point *cell, uint32_t child, int is_upper, int a, float c)
{
    cell->node = child + (uint32_t)is_upper;
    ++cell->depth;
    /* The box may already be smaller than the cell, so it is only cut. */
    if (is_upper) {
        if (c > cell->box.lo[a]) cell->box.lo[a] = c;
    } else {
        if (c < cell->box.hi[a]) cell->box.hi[a] = c;
    }
}

/* The set of children of a cell that rays of the beam can reach: NEAR_CHILD, FAR_CHILD, both or 0. */
MLRT_INLINE int reachable_children(const struct mlrt_job *job, const struct mlrt_beam *beam,
                                   const struct entry_point *cell, int a, float c, mlrt_counters *counters)
{
    /* The box may be smaller than the cell and lie on one side of the plane. */
    if (c > cell->box.hi[a]) return beam->negative[a] ? FAR_CHILD : NEAR_CHILD;
    if (c < cell->box.lo[a]) return beam->negative[a] ? NEAR_CHILD : FAR_CHILD;

    int children = job->multilevel.culling == MLRT_CULLING_INVERSE ? cull_inverse(beam, &cell->box, a, c)
                                                                   : cull_direct(beam, &cell->box, a, c);
    if (children != BOTH_CHILDREN) return children;
    ++counters->undecided_cull_count;
    if (job->multilevel.culling_check) children = check_children(beam, &cell->box, a, c);
    counters->undecided_checked_count += children == BOTH_CHILDREN;
    return children;
}

/* 1 if the leaf holds triangles and the beam may touch its box. */
MLRT_INLINE int has_potential(const struct mlrt_job *job, const struct mlrt_beam *beam, const struct mlrt_node *node,
                              const struct mlrt_box *box)
{
    if (mlrt_leaf_count(node) == 0) return 0;
    return !(job->multilevel.culling == MLRT_CULLING_INVERSE ? misses_box(beam, box)
                                                             : misses_box_along(beam, box, beam->main_axis));
}

MLRT_INLINE void enter_far_child(const struct mlrt_tree *tree, const struct mlrt_beam *beam, struct entry_point *cell)
{
    const struct mlrt_node *node = &tree->kdtree.nodes[cell->node];
    const int a = (int)mlrt_node_axis(node);
    enter_child(cell, mlrt_node_child(node), !beam->negative[a], a, node->u.split);
}

/*
 * Searches depth-first from `cell` for the first leaf with potential and stores it in *leaf. Returns 0 if there is
 * none. `stack` receives the bifurcations whose far child was not searched.
 */
static int find_first_leaf(const struct mlrt_job *job, const struct mlrt_beam *beam, struct entry_point cell,
                           struct entry_point *stack, int *stack_count, struct entry_point *leaf,
                           mlrt_counters *counters)
{
    *stack_count = 0;
    for (;;) {
        const struct mlrt_node *node = &job->tree->kdtree.nodes[cell.node];
        ++counters->cell_count;
        ++counters->entry_point_cell_count;
        int children = 0;
        if (!mlrt_node_is_leaf(node)) {
            const int a = (int)mlrt_node_axis(node);
            const float c = node->u.split;
            const int near_is_upper = beam->negative[a];
            children = reachable_children(job, beam, &cell, a, c, counters);
            if (children == BOTH_CHILDREN) stack[(*stack_count)++] = cell;
            if (children)
                enter_child(&cell, mlrt_node_child(node), children & NEAR_CHILD ? near_is_upper : !near_is_upper, a, c);
        } else if (has_potential(job, beam, node, &cell.box)) {
            *leaf = cell;
            return 1;
        }
        if (children) continue;
        if (*stack_count == 0) return 0;
        cell = stack[--*stack_count];
        enter_far_child(job->tree, beam, &cell);
    }
}

/*
 * The triangle that all rays of a beam surely hit before any other of the same leaf; MLRT_NONE if that is certain of no
 * triangle.
 */
static uint32_t find_first_cover(const uint32_t *entries, uint32_t count, const struct corner_terms *terms)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (!covers_beam(&terms[i])) continue;
        int is_first = 1;
        for (uint32_t j = 0; j < count && is_first; ++j)
            is_first = j == i || misses_beam(&terms[j]) || is_behind(&terms[j], &terms[i]);
        if (is_first) return entries[i];
    }
    return MLRT_NONE;
}

/*
 * Ends the beam's region at the triangles of a leaf that cover the beam. Returns the one that all rays hit before any
 * other of the leaf, or MLRT_NONE.
 */
static uint32_t look_for_cover(const struct mlrt_job *job, const struct entry_point *leaf, struct mlrt_beam *beam)
{
    struct corner_directions corners;
    struct corner_terms terms[COVER_TRIAL_LIMIT];
    const struct mlrt_node *node = &job->tree->kdtree.nodes[leaf->node];
    const uint32_t *entries = job->tree->kdtree.references + node->u.offset;
    const uint32_t count = mlrt_leaf_count(node);
    if (!beam->has_apex || !beam->may_cover || count > COVER_TRIAL_LIMIT) return MLRT_NONE;
    int is_covered = 0;
    set_corner_directions(beam, &corners);
    for (uint32_t i = 0; i < count; ++i) {
        set_corner_terms(&job->tree->triangles[entries[i]], beam, &corners, &terms[i]);
        if (!covers_beam(&terms[i])) continue;
        end_region_at_cover(&terms[i], &corners, beam);
        is_covered = 1;
    }
    return is_covered ? find_first_cover(entries, count, terms) : MLRT_NONE;
}

/* Goes down to the far child of `cell` and cuts its box down to the beam's region. Returns 0 if nothing is left. */
MLRT_INLINE int enter_far_region(const struct mlrt_tree *tree, const struct mlrt_beam *beam, struct entry_point *cell)
{
    enter_far_child(tree, beam, cell);
    return clip_to_region(beam, &cell->box);
}

int mlrt_find_entry_point(const struct mlrt_job *job, struct mlrt_beam *beam, struct entry_point *entry,
                          uint32_t *cover, mlrt_counters *counters)
{
    struct entry_point stack[MLRT_DEPTH_LIMIT], deeper[MLRT_DEPTH_LIMIT];
    int stack_count, deeper_count;
    struct entry_point leaf;
    ++counters->beam_count;
    if (!clip_to_region(beam, &entry->box)) return BEAM_MISSES;
    if (!find_first_leaf(job, beam, *entry, stack, &stack_count, &leaf, counters)) return BEAM_MISSES;
    *entry = leaf;
    *cover = look_for_cover(job, &leaf, beam);
    for (int i = 0; i < stack_count; ++i) {
        struct entry_point far = stack[i];
        if (!enter_far_region(job->tree, beam, &far)) continue;
        if (!find_first_leaf(job, beam, far, deeper, &deeper_count, &leaf, counters)) continue;
        *entry = stack[i];
        *cover = MLRT_NONE;
        break;
    }
    if (*cover != MLRT_NONE && (job->multilevel.shortcuts & MLRT_SHORTCUT_WHOLE_TILES) && beam->is_unlimited)
        return BEAM_IS_COVERED;
    return clip_to_region(beam, &entry->box) ? BEAM_ENTERS : BEAM_MISSES;
}

int mlrt_find_entry_list(const struct mlrt_job *job, struct mlrt_beam *beam, struct entry_point from,
                         struct entry_list *list, uint32_t *cover, mlrt_counters *counters)
{
    struct entry_point stack[MLRT_DEPTH_LIMIT], deeper[MLRT_DEPTH_LIMIT];
    int stack_count = 0;
    list->count = 0;
    *cover = MLRT_NONE;
    ++counters->beam_count;
    int inside = clip_to_region(beam, &from.box);
    for (;;) {
        int deeper_count;
        struct entry_point *leaf = &list->entries[list->count];
        if (inside && find_first_leaf(job, beam, from, deeper, &deeper_count, leaf, counters)) {
            ++list->count;
            *cover = look_for_cover(job, leaf, beam);
            memcpy(stack + stack_count, deeper, (size_t)deeper_count * sizeof *deeper);
            stack_count += deeper_count;
        }
        if (stack_count == 0) break;
        from = stack[--stack_count];
        inside = enter_far_region(job->tree, beam, &from);
        if (inside && list->count >= ENTRY_LIST_LEAVES) {
            list->entries[list->count++] = from;
            inside = 0;
        }
    }
    if (list->count == 0) return BEAM_MISSES;
    return list->count == 1 && *cover != MLRT_NONE && (job->multilevel.shortcuts & MLRT_SHORTCUT_WHOLE_TILES) &&
                   beam->is_unlimited
               ? BEAM_IS_COVERED
               : BEAM_ENTERS;
}
