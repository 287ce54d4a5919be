/* SPDX-License-Identifier: MIT */
/* Entry-point search: see entry_point.h. */
#include "mlrta/entry_point.h"

#include <string.h>

#include "job/job.h"
#include "mlrta/beam_culling.h"
#include "mlrta/covering.h"

/* Leaves of more triangles are not searched for a cover: there one triangle rarely covers a beam. */
#define COVER_TRIAL_LIMIT 8

/* Goes down to the near or far child of an inner node. */
MLRT_INLINE void enter_child(const struct mlrt_beam *beam, const struct mlrt_node *node, int is_far,
                             struct entry_point *cell)
{
    const int a = (int)mlrt_node_axis(node);
    const float c = node->u.split;
    const int is_upper = is_far ? !beam->negative[a] : beam->negative[a];
    cell->node = mlrt_node_child(node) + (uint32_t)is_upper;
    ++cell->depth;
    /* The box may already be smaller than the cell, so it is only cut. */
    if (is_upper) {
        if (c > cell->box.lo[a]) cell->box.lo[a] = c;
    } else {
        if (c < cell->box.hi[a]) cell->box.hi[a] = c;
    }
}

/* The set of children of a cell that rays of the beam can reach: NEAR_CHILD, FAR_CHILD, both or 0. */
MLRT_INLINE int reachable_children(const struct mlrt_job *job, const struct mlrt_beam *beam, const struct mlrt_box *box,
                                   int a, float c, mlrt_counters *counters)
{
    /* The box may be smaller than the cell and lie on one side of the plane. */
    if (c > box->hi[a]) return beam->negative[a] ? FAR_CHILD : NEAR_CHILD;
    if (c < box->lo[a]) return beam->negative[a] ? NEAR_CHILD : FAR_CHILD;

    int children = job->multilevel.culling == MLRT_CULLING_INVERSE ? cull_inverse(beam, box, a, c)
                                                                   : cull_direct(beam, box, a, c, 0);
    if (children != BOTH_CHILDREN) return children;
    ++counters->undecided_cull_count;
    if (job->multilevel.culling_check) children = cull_direct(beam, box, a, c, 1);
    counters->undecided_checked_count += children == BOTH_CHILDREN;
    return children;
}

/* 1 if the leaf holds triangles and the beam may touch its box. */
MLRT_INLINE int has_potential(const struct mlrt_job *job, const struct mlrt_beam *beam, const struct mlrt_node *node,
                              const struct mlrt_box *box)
{
    if (mlrt_leaf_count(node) == 0) return 0;
    return !misses_box(beam, box, job->multilevel.culling == MLRT_CULLING_INVERSE);
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
        if (mlrt_node_is_leaf(node)) {
            if (has_potential(job, beam, node, &cell.box)) {
                *leaf = cell;
                return 1;
            }
        } else {
            const int a = (int)mlrt_node_axis(node);
            const int children = reachable_children(job, beam, &cell.box, a, node->u.split, counters);
            if (children == BOTH_CHILDREN) stack[(*stack_count)++] = cell;
            if (children) {
                enter_child(beam, node, children == FAR_CHILD, &cell);
                continue;
            }
        }
        if (*stack_count == 0) return 0;
        cell = stack[--*stack_count];
        enter_child(beam, &job->tree->kdtree.nodes[cell.node], 1, &cell);
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
 * other of the leaf; MLRT_NONE if that is certain of none, if rays may end before it, or if whole tiles are switched
 * off.
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
    const int may_be_whole = (job->multilevel.shortcuts & MLRT_SHORTCUT_WHOLE_TILES) && beam->is_unlimited;
    return is_covered && may_be_whole ? find_first_cover(entries, count, terms) : MLRT_NONE;
}

/* Goes down to the far child of `cell` and cuts its box down to the beam's region. Returns 0 if nothing is left. */
MLRT_INLINE int enter_far_region(const struct mlrt_tree *tree, const struct mlrt_beam *beam, struct entry_point *cell)
{
    enter_child(beam, &tree->kdtree.nodes[cell->node], 1, cell);
    return clip_to_region(beam, &cell->box);
}

int mlrt_find_entry_point(const struct mlrt_job *job, struct mlrt_beam *beam, struct entry_point *entry,
                          uint32_t *cover, mlrt_counters *counters)
{
    struct entry_point stack[MLRT_DEPTH_LIMIT], deeper[MLRT_DEPTH_LIMIT];
    int stack_count, deeper_count;
    struct entry_point leaf;
    *cover = MLRT_NONE;
    ++counters->beam_count;
    if (!clip_to_region(beam, &entry->box)) return 0;
    if (!find_first_leaf(job, beam, *entry, stack, &stack_count, &leaf, counters)) return 0;
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
    return *cover == MLRT_NONE && clip_to_region(beam, &entry->box);
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
    return list->count > 1 || (list->count == 1 && *cover == MLRT_NONE);
}
