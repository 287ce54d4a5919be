/* SPDX-License-Identifier: MIT */
/*
 * traversal.h - one traversal of the library's kd-tree by single rays, for triangle tests from the literature
 *
 * Each test is compiled into this loop by inlining, so methods differ in their test alone. The traversal is that of
 * src/mlrta/ray.c, with node tests in double, but with wider margins, so that a wrong answer is due to the test and not
 * to the traversal:
 *
 *   - Every crossing of a plane may be off by 2^-20 of its distance (2^-50 would do for exact tests). If a ray passes
 *     near a corner, a test in float may report a neighbour of the triangle that it hits; the neighbour can be in the
 *     next leaf, which the ray does not touch. Without the margin, such wrong triangles became holes.
 *   - A cell counts as behind the nearest hit only if it is behind it by 2^-20 of the distance.
 *   - Of hits whose computed distances are equal, the first triangle of the mesh wins, as for the oracle.
 *
 * There is no mailbox; a triangle in several leaves may be tested again.
 *
 * Based on: V. Havran, "Heuristic Ray Shooting Algorithms", 2000, appendix C (recursive traversal with a stack).
 */
#ifndef TRAVERSAL_H
#define TRAVERSAL_H

#include "mlrta/kdtree.h"
#include "scene/tree.h"
#include "method.h"
#include "base/platform.h"

#include <math.h>

#define WALK_SLACK   0x1p-20
#define BEHIND_SLACK 0x1p-20

/* A ray, and what a test computes once for it if it wants to. */
struct study_ray {
    float origin[3];
    float direction[3];
    int axis[3];
    float shear[3];
};

typedef void (*ray_preparation)(struct study_ray *ray);

/*
 * Does the ray hit the triangle, and where? `table` is what the method prepared, if anything. Returns 1 and sets *t,
 * which may be anything (the walk looks if it is a distance in front), or 0. Tests in float store a float.
 */
typedef int (*triangle_test)(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                             const struct study_ray *ray, double *t);

struct stretch {
    double enter;
    double exit;
};

/* Distances at which the ray can cross the plane x_k = c; d_k is not 0. */
MLRT_INLINE struct stretch reach_plane(double c, double origin, double reciprocal)
{
    double t = (c - origin) * reciprocal, slack = fabs(t) * WALK_SLACK;
    return (struct stretch){t - slack, t + slack};
}

/* The part of the ray inside the closed box, or a little more. 0 if there is surely none. */
MLRT_INLINE int reach_box(const struct mlrt_box *box, const struct study_ray *ray, const double reciprocal[3],
                          struct stretch *part)
{
    *part = (struct stretch){0, INFINITY};
    for (int k = 0; k < 3; k++) {
        if (ray->direction[k] == 0) {
            if (ray->origin[k] < box->lo[k] || ray->origin[k] > box->hi[k]) return 0;
            continue;
        }
        struct stretch lo = reach_plane(box->lo[k], ray->origin[k], reciprocal[k]);
        struct stretch hi = reach_plane(box->hi[k], ray->origin[k], reciprocal[k]);
        double enter = ray->direction[k] < 0 ? hi.enter : lo.enter;
        double leave = ray->direction[k] < 0 ? lo.exit : hi.exit;
        if (enter > part->enter) part->enter = enter;
        if (leave < part->exit) part->exit = leave;
    }
    return part->enter <= part->exit;
}

MLRT_INLINE uint32_t walk(const struct mlrt_tree *tree, const void *table, triangle_test test,
                          const struct study_ray *ray, double *hit_t)
{
    struct {
        uint32_t node;
        struct stretch part;
    } stack[MLRT_DEPTH_LIMIT];
    int pending_count = 0;
    uint32_t node = 0, nearest = MLRT_NONE;
    double nearest_t = INFINITY, behind = INFINITY, reciprocal[3];
    struct stretch part;
    for (int k = 0; k < 3; k++) reciprocal[k] = ray->direction[k] == 0 ? 0 : 1.0 / ray->direction[k];
    *hit_t = INFINITY;
    if (!reach_box(&tree->bounds, ray, reciprocal, &part)) return MLRT_NONE;

    for (;;) {
        const struct mlrt_node *here = &tree->kdtree.nodes[node];
        if (!mlrt_node_is_leaf(here)) {
            uint32_t axis = mlrt_node_axis(here), child = mlrt_node_child(here);
            float d = ray->direction[axis], o = ray->origin[axis], c = here->u.split;
            uint32_t first = child + (d < 0), second = child + !(d < 0);
            struct stretch plane = part;
            if (d != 0) {
                plane = reach_plane(c, o, reciprocal[axis]);
            } else if (o != c) {
                node = o < c ? child : child + 1;
                continue;
            }
            if (part.exit < plane.enter) {
                node = first;
            } else if (part.enter > plane.exit) {
                node = second;
            } else {
                stack[pending_count].node = second;
                stack[pending_count].part.enter = plane.enter > part.enter ? plane.enter : part.enter;
                stack[pending_count++].part.exit = part.exit;
                if (plane.exit < part.exit) part.exit = plane.exit;
                node = first;
            }
            continue;
        }
        const uint32_t *entries = tree->kdtree.references + here->u.offset;
        uint32_t count = mlrt_leaf_count(here);
        for (uint32_t i = 0; i < count; i++) {
            double t;
            if (!test(table, tree->triangles, entries[i], ray, &t) || !(t > 0 && t <= nearest_t)) continue;
            if (t == nearest_t && entries[i] >= nearest) continue;
            nearest = entries[i];
            nearest_t = t;
            behind = t + t * BEHIND_SLACK;
        }
        do {
            if (pending_count == 0) {
                *hit_t = nearest_t;
                return nearest;
            }
            pending_count--;
            node = stack[pending_count].node;
            part = stack[pending_count].part;
        } while (part.enter > behind);
        if (part.exit > behind) part.exit = behind;
    }
}

/* Traces all rays. `prepare` may be NULL. Callers pass functions known to the compiler, so that they are inlined. */
MLRT_INLINE void walk_all(const struct method_run *run, const struct ray_set *rays, ray_preparation prepare,
                          triangle_test test, const struct answers *answers)
{
    for (size_t i = 0; i < rays->count; i++) {
        struct study_ray ray;
        for (int k = 0; k < 3; k++) {
            ray.origin[k] = rays->origins[i][k];
            ray.direction[k] = rays->directions[i][k];
        }
        if (prepare) prepare(&ray);
        double t;
        answers->triangles[i] = walk(run->subject->kdtree, run->state, test, &ray, &t);
        if (answers->t) answers->t[i] = (float)t;
    }
}

#endif
