/* SPDX-License-Identifier: MIT */
/*
 * Interval traversal: a group of rays goes down the tree as one, by the interval of distances within which its rays can
 * be in a cell. The cost of a step does not depend on the number of rays.
 *
 * If a direction component has the same sign in all rays of a group, their distances to the plane x_k = c lie within (c
 * - o_k) [1 / |d|_max, 1 / |d|_min]. c - o_k has one rounding, and so has each reciprocal and each product. The
 * reciprocals are moved apart by factors 1 -+ 2^-21, which covers all of these. The limits of packet.h on magnitudes
 * rule out overflow; if the last product underflows, its rounding still keeps the order. d_k = 0 makes a reciprocal
 * infinite; if the origin then lies in the plane, the product is a NaN, every comparison is false, and both children
 * are visited. Comparisons are strict, so both children are visited too if a ray only touches the plane, or the cell
 * has no thickness.
 *
 * Based on: Reshetov et al. 2005, section 4.3.
 */
#ifndef MLRT_MLRTA_INTERVAL_TRAVERSAL_H
#define MLRT_MLRTA_INTERVAL_TRAVERSAL_H

#include <math.h>

#include "base/counters.h"
#include "mlrta/entry_point.h"
#include "mlrta/kdtree.h"
#include "mlrta/outline.h"
#include "mlrta/packet_filter.h"
#include "mlrta/ray_group.h"
#include "mlrta/setups.h"
#include "mlrta/triangle_setup.h"
#include "rays/extremes.h"

struct distance_interval {
    float lo;
    float hi;
};

/*
 * The distances within which the rays of a group cross the plane x = c of this axis.
 *
 * With a common origin the bounds are not sorted: if the plane is behind the origin, both are negative, and since no
 * ray is in a cell at a negative distance, every comparison with either of them has the same answer.
 */
MLRT_INLINE struct distance_interval plane_distances(const struct group_axis *axis, float c, int has_apex)
{
    const float x = c - axis->origin_hi, y = c - axis->origin_lo;
    const float a = x * axis->small, b = x * axis->large;
    struct distance_interval t;
    if (has_apex) return (struct distance_interval){a, b};
    /* If a or b is a NaN, b is. As the second operand it then becomes both results. */
    t.lo = a < b ? a : b;
    t.hi = a > b ? a : b;
    if (x == y) return t;
    /* Origins differ: if one of them lies in the plane, its ray may, too. */
    if ((x == 0 || y == 0) && isinf(axis->large)) return (struct distance_interval){-INFINITY, INFINITY};
    const float e = y * axis->small, f = y * axis->large;
    const float lo = e < f ? e : f, hi = e > f ? e : f;
    t.lo = t.lo < lo ? t.lo : lo;
    t.hi = t.hi > hi ? t.hi : hi;
    return t;
}

/* Cuts `part` down to the distances at which the group can be in the closed box; lo > hi if it cannot. */
MLRT_INLINE struct distance_interval cut_to_box(const struct group_axis axis[3], const struct mlrt_box *box,
                                                struct distance_interval part, int has_apex)
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const float near = axis[k].negative ? box->hi[k] : box->lo[k], far = axis[k].negative ? box->lo[k] : box->hi[k];
        const float enter = plane_distances(&axis[k], near, has_apex).lo;
        const float exit = plane_distances(&axis[k], far, has_apex).hi;
        if (enter > part.lo) part.lo = enter;
        if (exit < part.hi) part.hi = exit;
    }
    return part;
}

/* A far child that waits on the stack. */
struct pending_cell {
    uint32_t node;
    struct distance_interval part;
};

/*
 * Tests a group against the triangles of a leaf. Lowers *farthest, the distance beyond which no ray of the group can
 * find a nearer hit.
 */
static void visit_leaf(const struct mlrt_job *job, const struct mlrt_node *leaf, float *farthest,
                       struct ray_group *group, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct mlrt_tree *tree = job->tree;
    const uint32_t *entries = tree->kdtree.references + leaf->u.offset;
    const uint32_t count = mlrt_leaf_count(leaf);
    uint32_t changed = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t number = entries[i];
        if (was_seen(group, number)) continue;
        struct mlrt_triangle_setup *setup = NULL;
        uint32_t touched = group->lanes;
        if (group->has_frustum) {
            setup = get_setup(tree, number, group, worker);
            touched = touched_lanes(group, &setup->outline, *farthest);
            if (!touched) continue;
            if (!setup->has_terms) set_up_terms(&tree->triangles[number], worker->setups->apex, setup);
            if (setup->in_plane) continue;
        }
        COUNT(&worker->counters, triangle_test_count, 1);
        changed |= test_triangle(job, number, setup, group, touched, packet, worker);
        if (MLRT_UNLIKELY(group->effort_left < 0)) break;
    }
    if (!changed) return;
    if (job->any) group->lanes &= ~changed;
    *farthest = highest(packet->nearest.hi, group->lanes); /* -inf if no lane is left, which ends the search */
}

/* Where a group is: at a node, at distances within `part`, with cells that wait on the stack. */
struct group_walk {
    uint32_t node;
    struct distance_interval part;
    int pending_count;
    struct pending_cell stack[MLRT_DEPTH_LIMIT];
};

/* Goes down to a leaf. */
MLRT_INLINE const struct mlrt_node *descend(const struct mlrt_node *nodes, const struct ray_group *group, int has_apex,
                                            struct group_walk *walk, struct mlrt_worker *worker)
{
    const struct mlrt_node *here = &nodes[walk->node];
    struct distance_interval part = walk->part;
    struct pending_cell *top = walk->stack + walk->pending_count;
    COUNT(&worker->counters, cell_count, 1);
    for (uint32_t k = mlrt_node_axis(here); k != 3; k = mlrt_node_axis(here)) {
        const struct group_axis *axis = &group->axis[k];
        const struct distance_interval plane = plane_distances(axis, here->u.split, has_apex);
        const uint32_t child = mlrt_node_child(here);
        uint32_t node = child + axis->negative;
        if (!(part.hi < plane.lo)) {
            const uint32_t second = child + !axis->negative;
            if (part.lo > plane.hi) {
                node = second;
            } else {
                top->node = second;
                top->part.lo = plane.lo > part.lo ? plane.lo : part.lo;
                top->part.hi = part.hi;
                ++top;
                if (plane.hi < part.hi) part.hi = plane.hi;
            }
        }
        here = &nodes[node];
        COUNT(&worker->counters, cell_count, 1);
    }
    walk->part = part;
    walk->pending_count = (int)(top - walk->stack);
    return here;
}

/* Traces a group through the subtree of `node`; its rays are in the cell of `node` at distances within `part`. */
static void traverse_subtree(const struct mlrt_job *job, uint32_t node, struct distance_interval part, float *farthest,
                             struct ray_group *group, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    struct group_walk walk;
    walk.node = node;
    walk.part = part;
    walk.pending_count = 0;
    for (;;) {
        const struct mlrt_node *nodes = job->tree->kdtree.nodes;
        const struct mlrt_node *leaf =
            group->has_frustum ? descend(nodes, group, 1, &walk, worker) : descend(nodes, group, 0, &walk, worker);
        visit_leaf(job, leaf, farthest, group, packet, worker);
        if (MLRT_UNLIKELY(--group->effort_left < 0)) return;
        for (;;) {
            if (walk.pending_count == 0) return;
            const struct pending_cell *next = &walk.stack[--walk.pending_count];
            walk.node = next->node;
            walk.part = next->part;
            if (!(walk.part.lo > *farthest)) break;
            COUNT(&worker->counters, cell_count, 1);
        }
        if (walk.part.hi > *farthest) walk.part.hi = *farthest;
    }
}

/* Traces a group from the nodes of a list. */
static void traverse_list(const struct mlrt_job *job, const struct entry_list *list, struct ray_group *group,
                          struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const int has_outlines = group->has_frustum && list->axis_code == group->axis_code;
    float farthest = group->range.hi[3];
    for (uint32_t i = 0; i < list->count; ++i) {
        if (has_outlines && !touched_lanes(group, &list->outlines[i], farthest)) {
            COUNT(&worker->counters, cell_count, 1);
            continue;
        }
        const struct distance_interval ray = {group->range.lo[3], farthest};
        const struct mlrt_box *box = &list->entries[i].box;
        const struct distance_interval part =
            group->has_frustum ? cut_to_box(group->axis, box, ray, 1) : cut_to_box(group->axis, box, ray, 0);
        if (part.lo > part.hi) {
            COUNT(&worker->counters, cell_count, 1);
            continue;
        }
        traverse_subtree(job, list->entries[i].node, part, &farthest, group, packet, worker);
        if (MLRT_UNLIKELY(group->effort_left < 0)) return;
    }
}

/* Traces the active rays of a packet from the nodes of a list, one group after the other. */
static void traverse_interval(const struct mlrt_job *job, const struct entry_list *list, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    for (uint32_t left = packet->active; left;) {
        struct ray_group group;
        make_group(packet, left, &job->tree->bounds, &group);
        left &= ~group.lanes;
        COUNT(&worker->counters, packet_count, 1);
        traverse_list(job, list, &group, packet, worker);
        if (MLRT_UNLIKELY(group.effort_left < 0)) packet->in_double |= group.lanes;
    }
}

#endif
