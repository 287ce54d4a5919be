/* SPDX-License-Identifier: MIT */
/*
 * Interval traversal: a packet goes down the tree as one, by the interval of distances at which its rays can be in a
 * cell. The cost of a step does not depend on the number of rays.
 *
 * With all signs of a direction component equal, the distances of a group's rays to the plane x_k = c are within
 * (c - o_k) [1 / |d|_max, 1 / |d|_min]. c - o_k has one rounding, the reciprocals and the products one each: the
 * reciprocals are moved apart by a factor 1 -+ 2^-21, which pays for all of them; packet.h's limits on the magnitudes
 * rule out overflow and underflow. d_k = 0 makes a reciprocal infinite; in the plane itself the product is then a NaN,
 * every comparison is false, and both children are visited. Comparisons are strict, so a ray that grazes a plane, and a
 * cell without thickness, see both sides.
 *
 * Based on: Reshetov et al. 2005, section 4.3.
 */

/* Where a traversal starts: a node, and a box that contains all that matters of its cell. */
struct entry_point {
    uint32_t node;
    uint32_t depth;
    struct mlrt_box box;
};

struct distance_interval {
    float lo;
    float hi;
};

MLRT_INLINE struct distance_interval plane_distances(const struct group_axis *axis, float c)
{
    const float x = c - axis->origin_hi, y = c - axis->origin_lo;
    const float a = x * axis->small, b = x * axis->large;
    struct distance_interval t;
    /* The operand that can be a NaN stands second, where the comparison keeps it. */
    t.lo = a < b ? a : b;
    t.hi = a > b ? a : b;
    if (x == y) return t;
    /* Different origins: one of them may lie in the plane, and its ray too. */
    if ((x == 0 || y == 0) && isinf(axis->large)) return (struct distance_interval){-INFINITY, INFINITY};
    const float e = y * axis->small, f = y * axis->large;
    const float lo = e < f ? e : f, hi = e > f ? e : f;
    t.lo = t.lo < lo ? t.lo : lo;
    t.hi = t.hi > hi ? t.hi : hi;
    return t;
}

/* The distances at which the group can be in the closed box; lo > hi if nowhere. */
MLRT_INLINE struct distance_interval box_distances(const struct group_axis axis[3], const struct mlrt_box *box,
                                                   struct distance_interval part)
{
    for (int k = 0; k < 3; ++k) {
        const struct distance_interval below = plane_distances(&axis[k], box->lo[k]);
        const struct distance_interval above = plane_distances(&axis[k], box->hi[k]);
        const float enter = axis[k].negative ? above.lo : below.lo, exit = axis[k].negative ? below.hi : above.hi;
        if (enter > part.lo) part.lo = enter;
        if (exit < part.hi) part.hi = exit;
    }
    return part;
}

struct pending_cell {
    uint32_t node;
    struct distance_interval part;
};

/* Traces a group from an entry point. */
static void traverse_group(const struct mlrt_job *job, const struct entry_point *entry, struct ray_group *group,
                           struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct mlrt_tree *tree = job->tree;
    const struct group_axis *axis = group->axis;
    mlrt_counters *counters = &worker->counters;
    struct distance_interval part = {lowest(packet->t_min, group->lanes), highest(packet->hi, group->lanes)};
    part = box_distances(axis, &entry->box, part);
    if (part.lo > part.hi) return;

    struct pending_cell stack[MLRT_DEPTH_LIMIT];
    int pending_count = 0;
    uint32_t node = entry->node;
    float farthest = part.hi; /* of the nearest hits so far: what lies behind concerns no ray */
    COUNT(counters, packet_count, 1);
    for (;;) {
        const struct mlrt_node *here = &tree->nodes[node];
        COUNT(counters, cell_count, 1);
        const uint32_t k = mlrt_node_axis(here);
        if (k != 3) {
            const struct distance_interval plane = plane_distances(&axis[k], here->u.split);
            const uint32_t child = mlrt_node_child(here), first = child + axis[k].negative, second = child + !axis[k].negative;
            if (part.hi < plane.lo) {
                node = first;
            } else if (part.lo > plane.hi) {
                node = second;
            } else {
                stack[pending_count].node = second;
                stack[pending_count].part.lo = plane.lo > part.lo ? plane.lo : part.lo;
                stack[pending_count].part.hi = part.hi;
                ++pending_count;
                if (plane.hi < part.hi) part.hi = plane.hi;
                node = first;
            }
            continue;
        }
        const uint32_t *entries = tree->references + here->u.offset;
        const uint32_t count = mlrt_leaf_count(here);
        uint32_t changed = 0;
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t number = entries[i];
            if (was_seen(group, number)) continue;
            struct mlrt_triangle_setup *setup = NULL;
            uint32_t touched = group->lanes;
            if (group->has_frustum) {
                setup = get_setup(tree, number, group, worker);
                touched = touched_lanes(group, setup, farthest);
                if (!touched) continue;
                if (!setup->has_terms) set_up_terms(&tree->triangles[number], worker->apex, setup);
            }
            COUNT(counters, triangle_test_count, 1);
            changed |= test_triangle(tree, number, setup, group, touched, packet, counters);
        }
        if (changed) {
            if (job->any) {
                group->lanes &= ~changed;
                if (!group->lanes) return;
            }
            farthest = highest(packet->hi, group->lanes);
        }
        do {
            if (pending_count == 0) return;
            --pending_count;
            node = stack[pending_count].node;
            part = stack[pending_count].part;
        } while (part.lo > farthest);
        if (part.hi > farthest) part.hi = farthest;
    }
}

/* Traces a packet's active rays from an entry point, in as many groups as they make. */
static void traverse_interval(const struct mlrt_job *job, const struct entry_point *entry, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    for (uint32_t left = packet->active; left;) {
        struct ray_group group;
        make_group(packet, left, &group);
        left &= ~group.lanes;
        traverse_group(job, entry, &group, packet, worker);
    }
}
