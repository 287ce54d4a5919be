/* SPDX-License-Identifier: MIT */
/*
 * One ray through the hierarchy of boxes. The children of a node that the ray can meet go on a stack, the nearest on
 * top. Children that start behind the nearest hit so far are skipped.
 *
 * Box tests are in double (exact/ray_interval.h): a box is skipped only if the ray certainly misses it, or certainly
 * meets it behind the nearest hit. Where d_k is 0, coordinate k of the ray is constant, and its comparison with the box
 * is exact. Boxes are scaled out of their units (unit.h), which is exact in double too. Bounds may be infinite, but
 * `lo` of a box is never inf, and `hi` never -inf: an infinite bound cuts nothing off.
 */
#include "bvh/node.h"

#include "exact/nearest.h"
#include "exact/ray_interval.h"
#include "scene/masks.h"

/* A child that the ray can meet, from t = enter on. */
struct pending {
    double enter;
    uint32_t child;
};

struct search {
    const struct mlrt_tree *tree;
    const struct mlrt_ray_segment *ray;
    double reciprocal[3];
    double inverse_unit; /* the factor that takes boxes out of units */
    struct mlrt_nearest nearest;
    struct pending stack[MLRT_BVH_STACK_LIMIT];
    uint32_t pending_count;
};

/* The part of the ray inside each box of a node, from t = enter to t = exit. Arbitrary for empty slots. */
struct parts {
    double enter[MLRT_BVH_WIDTH];
    double exit[MLRT_BVH_WIDTH];
};

/*
 * Narrows the parts to the slabs between the boxes' planes across axis k. The loops run over all slots, so that
 * compilers vectorize them.
 */
static void clip_to_slabs(const struct search *search, const struct mlrt_bvh_node *node, int k, struct parts *parts)
{
    const double o = search->ray->origin[k], r = search->reciprocal[k], scale = search->inverse_unit;
    const float d = search->ray->direction[k];
    const float *near = d < 0 ? node->hi[k] : node->lo[k], *far = d < 0 ? node->lo[k] : node->hi[k];
    if (d == 0) {
        for (int i = 0; i < MLRT_BVH_WIDTH; ++i)
            if (o < near[i] * scale || o > far[i] * scale) parts->exit[i] = -1;
        return;
    }
    for (int i = 0; i < MLRT_BVH_WIDTH; ++i) {
        const double enter = mlrt_plane_distance(near[i] * scale, o, r).enter;
        const double exit = mlrt_plane_distance(far[i] * scale, o, r).exit;
        parts->enter[i] = enter > parts->enter[i] ? enter : parts->enter[i];
        parts->exit[i] = exit < parts->exit[i] ? exit : parts->exit[i];
    }
}

/* Puts the children that the ray can meet on the stack, the nearest on top. */
static void push_children(const struct mlrt_bvh_node *node, struct search *search)
{
    struct parts parts;
    for (int i = 0; i < MLRT_BVH_WIDTH; ++i) {
        parts.enter[i] = search->ray->t_min;
        parts.exit[i] = search->nearest.hi;
    }
    for (int k = 0; k < 3; ++k) clip_to_slabs(search, node, k, &parts);
    const uint32_t first = search->pending_count;
    for (uint32_t i = 0; i < MLRT_BVH_WIDTH && node->child[i]; ++i) {
        if (parts.enter[i] > parts.exit[i]) continue;
        uint32_t place = search->pending_count++;
        for (; place > first && search->stack[place - 1].enter < parts.enter[i]; --place)
            search->stack[place] = search->stack[place - 1];
        search->stack[place] = (struct pending){parts.enter[i], node->child[i]};
    }
}

/* Offers the triangles of a leaf to the ray. Returns 1 if the search ends: with `any`, at the first hit. */
static int test_leaf(struct search *search, uint32_t leaf, uint32_t skip, int any, struct mlrt_hit_list *list,
                     mlrt_counters *counters)
{
    const uint32_t *numbers = search->tree->bvh.numbers + 4 * mlrt_bvh_offset(leaf);
    const uint32_t limit = 4 * mlrt_bvh_quad_count(leaf);
    for (uint32_t i = 0; i < limit && numbers[i] != MLRT_NONE; ++i) {
        if (numbers[i] == skip || mlrt_is_hidden(search->tree, numbers[i], search->ray->mask)) continue;
        if (counters) ++counters->triangle_test_count;
        if (list) {
            mlrt_gather_hit(&search->tree->by_number, search->ray, numbers[i], list, counters);
        } else if (numbers[i] != search->nearest.triangle) {
            if (mlrt_offer_triangle(&search->tree->by_number, search->ray, numbers[i], &search->nearest, counters) &&
                any)
                return 1;
        }
    }
    return 0;
}

uint32_t mlrt_trace_boxes(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters)
{
    struct search search;
    if (tree->bvh.node_count == 0) return MLRT_NONE;
    search.tree = tree;
    search.ray = ray;
    search.nearest = (struct mlrt_nearest){MLRT_NONE, ray->t_max, ray->t_max};
    search.pending_count = 0;
    search.inverse_unit = 1 / (double)tree->bvh.unit;
    mlrt_reciprocal_direction(ray, search.reciprocal);
    if (counters) ++counters->cell_count;
    push_children(&tree->bvh.nodes[0], &search);
    while (search.pending_count > 0) {
        const struct pending next = search.stack[--search.pending_count];
        if (next.enter > search.nearest.hi) continue;
        if (counters) ++counters->cell_count;
        if (mlrt_bvh_quad_count(next.child) == 0) {
            push_children(&tree->bvh.nodes[mlrt_bvh_offset(next.child)], &search);
        } else if (test_leaf(&search, next.child, skip, any, list, counters)) {
            break;
        }
    }
    return search.nearest.triangle;
}
