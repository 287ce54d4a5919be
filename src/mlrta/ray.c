/* SPDX-License-Identifier: MIT */
/*
 * One ray through the kd-tree: near child first, far child on a stack, up to the nearest hit so far.
 *
 * Node tests are in double (exact/ray_interval.h): a cell is skipped only if its interval is surely empty or surely
 * behind the nearest hit.
 *
 * Based on: V. Havran, "Heuristic Ray Shooting Algorithms", 2000, appendix C (recursive traversal with a stack).
 */
#include "mlrta/kdtree.h"

#include "base/platform.h"
#include "exact/nearest.h"
#include "exact/ray_interval.h"
#include "scene/masks.h"
#include "scene/tree.h"

/* Sets *part to the interval of the ray in the closed box, or a little more. Returns 0 if it surely is empty. */
static int clip_to_box(const struct mlrt_ray_segment *ray, const double reciprocal[3], const struct mlrt_box *box,
                       struct mlrt_interval *part)
{
    part->enter = ray->t_min;
    part->exit = ray->t_max;
    for (int k = 0; k < 3; ++k) {
        if (ray->direction[k] == 0) {
            if (ray->origin[k] < box->lo[k] || ray->origin[k] > box->hi[k]) return 0;
            continue;
        }
        int negative = ray->direction[k] < 0;
        struct mlrt_interval near =
            mlrt_plane_distance(negative ? box->hi[k] : box->lo[k], ray->origin[k], reciprocal[k]);
        struct mlrt_interval far =
            mlrt_plane_distance(negative ? box->lo[k] : box->hi[k], ray->origin[k], reciprocal[k]);
        if (near.enter > part->enter) part->enter = near.enter;
        if (far.exit < part->exit) part->exit = far.exit;
    }
    return part->enter <= part->exit;
}

/* A far child that waits on the stack. */
struct pending {
    uint32_t node;
    struct mlrt_interval part;
};

/*
 * With a list, adds every hit to it and returns MLRT_NONE. Else returns the triangle of the nearest hit; if `any`, of
 * the first hit found.
 */
MLRT_INLINE uint32_t trace(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                           struct mlrt_hit_list *list, mlrt_counters *counters)
{
    struct mlrt_nearest nearest = {MLRT_NONE, ray->t_max, ray->t_max};
    double reciprocal[3];
    mlrt_reciprocal_direction(ray, reciprocal);

    struct pending stack[MLRT_DEPTH_LIMIT];
    int pending_count = 0;
    uint32_t node = 0;
    struct mlrt_interval part;
    if (!clip_to_box(ray, reciprocal, &tree->bounds, &part)) return MLRT_NONE;

    for (;;) {
        const struct mlrt_node *here = &tree->kdtree.nodes[node];
        if (counters) ++counters->cell_count;
        if (!mlrt_node_is_leaf(here)) {
            uint32_t axis = mlrt_node_axis(here), child = mlrt_node_child(here);
            float d = ray->direction[axis], o = ray->origin[axis], c = here->u.split;
            uint32_t first = child + (d < 0), second = child + !(d < 0);
            struct mlrt_interval plane = {part.enter, part.exit};
            if (d != 0) {
                plane = mlrt_plane_distance(c, o, reciprocal[axis]);
            } else if (o != c) {
                node = o < c ? child : child + 1;
                continue;
            }
            if (part.exit < plane.enter) {
                node = first;
            } else if (part.enter > plane.exit) {
                node = second;
            } else {
                struct mlrt_interval far = {plane.enter > part.enter ? plane.enter : part.enter, part.exit};
                stack[pending_count++] = (struct pending){second, far};
                if (plane.exit < part.exit) part.exit = plane.exit;
                node = first;
            }
            continue;
        }
        const uint32_t *entries = tree->kdtree.references + here->u.offset;
        uint32_t count = mlrt_leaf_count(here);
        for (uint32_t i = 0; i < count; ++i) {
            if (entries[i] == skip || mlrt_is_hidden(tree, entries[i], ray->mask)) continue;
            if (counters) ++counters->triangle_test_count;
            if (list) {
                mlrt_gather_hit(&tree->by_number, ray, entries[i], list, counters);
                continue;
            }
            if (mlrt_offer_triangle(&tree->by_number, ray, entries[i], &nearest, counters) && any)
                return nearest.triangle;
        }
        do {
            if (pending_count == 0) return nearest.triangle;
            --pending_count;
            node = stack[pending_count].node;
            part = stack[pending_count].part;
        } while (part.enter > nearest.hi);
        if (part.exit > nearest.hi) part.exit = nearest.hi;
    }
}

uint32_t mlrt_trace_cells(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters)
{
    if (list || counters) return trace(tree, ray, skip, any, list, counters);
    return trace(tree, ray, skip, any, NULL, NULL);
}
