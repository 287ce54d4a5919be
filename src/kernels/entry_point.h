/* SPDX-License-Identifier: MIT */
/*
 * Entry-point search: the deepest node at which every ray of a beam may start.
 *
 * First a depth-first search, near child first, to the first leaf with potential: one that holds triangles and that the
 * beam may touch. Nodes where both children remained are kept on a LIFO stack. Then, from the top of that stack down, the
 * far children are searched: if one leads to a leaf with potential, its bifurcation is the new candidate. What remains is
 * the lowest node above all leaves with potential. If a leaf holds a triangle that all rays of the beam hit, nothing
 * behind it matters, and the beam's region ends there.
 *
 * Based on: Reshetov et al. 2005, section 4.1.
 */

/* Triangles of a leaf that are tried as covers: in larger leaves one triangle rarely covers a beam. */
#define COVER_TRIAL_LIMIT 8

struct bifurcation {
    struct entry_point cell;
    struct entry_point far;
};

MLRT_INLINE struct entry_point child_cell(const struct entry_point *cell, uint32_t child, int is_upper, int a, float c)
{
    struct entry_point below = *cell;
    below.node = child + (uint32_t)is_upper;
    ++below.depth;
    if (is_upper) {
        below.box.lo[a] = c;
    } else {
        below.box.hi[a] = c;
    }
    return below;
}

/* Which children can rays of the beam reach: NEAR_CHILD and FAR_CHILD or-ed together, or 0. */
MLRT_INLINE int reachable_children(const struct mlrt_job *job, const struct mlrt_beam *beam,
                                   const struct entry_point *cell, const struct entry_point *near,
                                   const struct entry_point *far, int a, float c, mlrt_counters *counters)
{
    /* The box may be less than the cell, and lie on one side of the plane. */
    if (c > cell->box.hi[a]) return beam->negative[a] ? FAR_CHILD : NEAR_CHILD;
    if (c < cell->box.lo[a]) return beam->negative[a] ? NEAR_CHILD : FAR_CHILD;

    int children;
    if (job->culling == MLRT_CULLING_INVERSE) {
        children = cull_inverse(beam, &cell->box, a, c);
    } else {
        children = (misses_box_along(beam, &near->box, beam->main_axis) ? 0 : NEAR_CHILD) |
                   (misses_box_along(beam, &far->box, beam->main_axis) ? 0 : FAR_CHILD);
    }
    if (children != BOTH_CHILDREN) return children;
    COUNT(counters, undecided_cull_count, 1);
    if (job->culling_check) {
        children = (misses_box(beam, &near->box) ? 0 : NEAR_CHILD) | (misses_box(beam, &far->box) ? 0 : FAR_CHILD);
    }
    COUNT(counters, undecided_checked_count, children == BOTH_CHILDREN);
    return children;
}

MLRT_INLINE int has_potential(const struct mlrt_job *job, const struct mlrt_beam *beam, const struct mlrt_node *node,
                              const struct mlrt_box *box)
{
    if (mlrt_leaf_count(node) == 0) return 0;
    return !(job->culling_check ? misses_box(beam, box) : misses_box_along(beam, box, beam->main_axis));
}

/*
 * Depth-first from `cell` to the first leaf with potential, which *leaf becomes. Returns 0 if there is none. Leaves the
 * bifurcations whose far child was not looked at on `stack`.
 */
static int find_first_leaf(const struct mlrt_job *job, const struct mlrt_beam *beam, struct entry_point cell,
                           struct bifurcation *stack, int *stack_count, struct entry_point *leaf,
                           mlrt_counters *counters)
{
    *stack_count = 0;
    for (;;) {
        const struct mlrt_node *node = &job->tree->nodes[cell.node];
        COUNT(counters, cell_count, 1);
        COUNT(counters, entry_point_cell_count, 1);
        int children = 0;
        if (!mlrt_node_is_leaf(node)) {
            const int a = (int)mlrt_node_axis(node);
            const float c = node->u.split;
            const struct entry_point near = child_cell(&cell, mlrt_node_child(node), beam->negative[a], a, c);
            const struct entry_point far = child_cell(&cell, mlrt_node_child(node), !beam->negative[a], a, c);
            children = reachable_children(job, beam, &cell, &near, &far, a, c, counters);
            if (children == BOTH_CHILDREN) {
                stack[*stack_count].cell = cell;
                stack[(*stack_count)++].far = far;
            }
            if (children) cell = children & NEAR_CHILD ? near : far;
        } else if (has_potential(job, beam, node, &cell.box)) {
            *leaf = cell;
            return 1;
        }
        if (children) continue;
        if (*stack_count == 0) return 0;
        cell = stack[--*stack_count].far;
    }
}

/* Ends the beam's region at triangles of the leaf that cover it. */
static void look_for_cover(const struct mlrt_job *job, const struct entry_point *leaf, struct mlrt_beam *beam)
{
    const struct mlrt_node *node = &job->tree->nodes[leaf->node];
    const uint32_t count = mlrt_leaf_count(node);
    if (!beam->has_apex || !beam->may_cover || count > COVER_TRIAL_LIMIT) return;
    for (uint32_t i = 0; i < count; ++i) {
        end_region_at_cover(&job->tree->triangles[job->tree->references[node->u.offset + i]], beam);
    }
}

/* Replaces *entry, from where the beam's rays may start, by the deepest such node. 0 if no ray hits anything. */
static int find_entry_point(const struct mlrt_job *job, struct mlrt_beam *beam, struct entry_point *entry,
                            mlrt_counters *counters)
{
    struct bifurcation stack[MLRT_DEPTH_LIMIT], deeper[MLRT_DEPTH_LIMIT];
    int stack_count, deeper_count;
    struct entry_point leaf, candidate;
    COUNT(counters, beam_count, 1);
    if (!clip_to_region(beam, &entry->box)) return 0;
    if (!find_first_leaf(job, beam, *entry, stack, &stack_count, &leaf, counters)) return 0;
    candidate = leaf;
    look_for_cover(job, &leaf, beam);
    while (stack_count > 0) {
        struct bifurcation *top = &stack[--stack_count];
        if (!clip_to_region(beam, &top->far.box)) continue;
        if (!find_first_leaf(job, beam, top->far, deeper, &deeper_count, &leaf, counters)) continue;
        candidate = top->cell;
        look_for_cover(job, &leaf, beam);
    }
    *entry = candidate;
    return clip_to_region(beam, &entry->box);
}
