/* SPDX-License-Identifier: MIT */
/*
 * box_walk.c - a textbook ray tracer over the library's own hierarchy of boxes: the triangle test of Moeller and
 * Trumbore in float, one ray at a time, in plain C
 *
 * What a programmer writes in an evening who has the hierarchy already: slabs in float, children on a stack, the
 * nearest on top, triangles from the caller's vertices and indices. No bound is kept, and no edge belongs to anyone.
 *
 * Based on: T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997; T. Kay, J. Kajiya, "Ray
 * Tracing Complex Scenes", 1986 (slabs).
 */
#include "bvh/node.h"
#include "method.h"
#include "scene/tree.h"
#include "vector.h"

#include <math.h>

struct pending {
    float enter;
    uint32_t child;
};

struct walk {
    const struct mlrt_tree *tree;
    const struct scene *scene;
    float origin[3], direction[3];
    float scaled_origin[3], scaled_reciprocal[3]; // in the units of the boxes
    float nearest_t;
    uint32_t nearest;
    struct pending stack[MLRT_BVH_WIDTH * MLRT_BVH_DEPTH_LIMIT];
    int pending_count;
};

// The loops run over all slots, so that the compiler makes vectors of them.
static void push_children(struct walk *walk, const struct mlrt_bvh_node *node)
{
    const int first = walk->pending_count;
    float enter[MLRT_BVH_WIDTH], exit[MLRT_BVH_WIDTH];
    for (int i = 0; i < MLRT_BVH_WIDTH; i++) enter[i] = 0, exit[i] = walk->nearest_t;
    for (int k = 0; k < 3; k++) {
        const float o = walk->scaled_origin[k], r = walk->scaled_reciprocal[k];
        const float *near = r < 0 ? node->hi[k] : node->lo[k], *far = r < 0 ? node->lo[k] : node->hi[k];
        for (int i = 0; i < MLRT_BVH_WIDTH; i++) {
            const float in = (near[i] - o) * r, out = (far[i] - o) * r;
            enter[i] = in > enter[i] ? in : enter[i];
            exit[i] = out < exit[i] ? out : exit[i];
        }
    }
    for (int i = 0; i < MLRT_BVH_WIDTH && node->child[i]; i++) {
        if (enter[i] > exit[i]) continue;
        int place = walk->pending_count++;
        for (; place > first && walk->stack[place - 1].enter < enter[i]; place--)
            walk->stack[place] = walk->stack[place - 1];
        walk->stack[place] = (struct pending){enter[i], node->child[i]};
    }
}

static void test_triangle(struct walk *walk, uint32_t number)
{
    const uint32_t *corners = walk->scene->indices + 3 * (size_t)number;
    const float *a = walk->scene->vertices + 3 * (size_t)corners[0],
                *b = walk->scene->vertices + 3 * (size_t)corners[1],
                *c = walk->scene->vertices + 3 * (size_t)corners[2];
    float e1[3], e2[3], p[3], s[3], q[3];
    subtract_float(b, a, e1);
    subtract_float(c, a, e2);
    cross_float(walk->direction, e2, p);
    const float determinant = dot_float(e1, p);
    if (determinant == 0) return;
    subtract_float(walk->origin, a, s);
    const float u = dot_float(s, p) / determinant;
    if (!(u >= 0 && u <= 1)) return;
    cross_float(s, e1, q);
    const float v = dot_float(walk->direction, q) / determinant;
    if (!(v >= 0 && u + v <= 1)) return;
    const float t = dot_float(e2, q) / determinant;
    if (t > 0 && t < walk->nearest_t) walk->nearest_t = t, walk->nearest = number;
}

static uint32_t trace_ray(struct walk *walk)
{
    const struct mlrt_bvh *boxes = &walk->tree->bvh;
    if (boxes->node_count == 0) return MLRT_NONE;
    for (int k = 0; k < 3; k++) {
        walk->scaled_origin[k] = walk->origin[k] * boxes->unit;
        walk->scaled_reciprocal[k] = 1 / (walk->direction[k] * boxes->unit);
    }
    walk->nearest_t = INFINITY, walk->nearest = MLRT_NONE, walk->pending_count = 0;
    push_children(walk, &boxes->nodes[0]);
    while (walk->pending_count > 0) {
        const struct pending next = walk->stack[--walk->pending_count];
        if (next.enter > walk->nearest_t) continue;
        const uint32_t offset = mlrt_bvh_offset(next.child), quads = mlrt_bvh_quad_count(next.child);
        if (quads == 0) push_children(walk, &boxes->nodes[offset]);
        for (uint32_t i = 4 * offset; i < 4 * (offset + quads) && boxes->numbers[i] != MLRT_NONE; i++) {
            test_triangle(walk, boxes->numbers[i]);
        }
    }
    return walk->nearest;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    struct walk walk = {.tree = run->subject->boxes, .scene = &run->subject->scene};
    for (size_t i = 0; i < rays->count; i++) {
        for (int k = 0; k < 3; k++) walk.origin[k] = rays->origins[i][k], walk.direction[k] = rays->directions[i][k];
        answers->triangles[i] = trace_ray(&walk);
        if (answers->t) answers->t[i] = walk.nearest_t;
    }
}

const struct method box_walk_methods[] = {
    {"mt_boxes", "Moeller-Trumbore, float, over the same boxes", 0, 0, 0, NULL, trace, NULL},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
