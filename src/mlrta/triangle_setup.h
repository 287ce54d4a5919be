/* SPDX-License-Identifier: MIT */
/*
 * Set-ups of triangles: the outline of a triangle as seen from an apex, and the terms of its edge functions, which all
 * packets from that apex share. A worker keeps a small table of them for neighbouring packets.
 */
#ifndef MLRT_MLRTA_TRIANGLE_SETUP_H
#define MLRT_MLRTA_TRIANGLE_SETUP_H

#include <math.h>
#include <string.h>

#include "hits/triangle_filter.h"
#include "mlrta/outline.h"
#include "mlrta/ray_group.h"
#include "mlrta/setups.h"
#include "rays/extremes.h"

/* Empties the worker's table for packets from another apex. */
static void forget_setups(const float apex[3], struct mlrt_worker *worker)
{
    struct mlrt_setups *setups = worker->setups;
    for (uint32_t i = 0; i <= setups->mask; ++i) setups->entries[i].number = MLRT_NONE;
    memcpy(setups->apex, apex, sizeof setups->apex);
}

/* The table's entry for a triangle, with its outline. Its terms are only set if has_terms says so. */
MLRT_INLINE struct mlrt_triangle_setup *get_setup(const struct mlrt_tree *tree, uint32_t number,
                                                  const struct ray_group *group, struct mlrt_worker *worker)
{
    struct mlrt_triangle_setup *setup = &worker->setups->entries[number & worker->setups->mask];
    if (setup->number == number && setup->axis_code == group->axis_code) return setup;
    setup->has_terms = 0;
    setup->number = number;
    setup->axis_code = group->axis_code;
    set_triangle_outline(&tree->triangles[number], group->axis_code, worker->setups->apex, &setup->outline);
    return setup;
}

/* Weights of the components of a cross product in its size, by main axis (hits/triangle_filter.h). */
static const float axis_weights[3][3] = {{1, 0.5f, 0.5f}, {0.5f, 1, 0.5f}, {0.5f, 0.5f, 1}};

/*
 * Sets the terms of an entry (hits/triangle_filter.h): those of the three edges and of the normal at once. Not inlined:
 * 700 bytes less in SSE2, and 1 % more instructions for 2x2 packets.
 */
static MLRT_NOINLINE void set_up_terms(const struct mlrt_triangle *triangle, const float apex[3],
                                       struct mlrt_triangle_setup *setup)
{
    const float *weight = axis_weights[setup->axis_code & 3];
    f4 corner[3], sum[3], edge[3], magnitude[3], length[3], scale = f4_set1(1);
    f4_corners(triangle->v, corner);
    float vertex[3];
    for (int k = 0; k < 3; ++k) {
        const f4 to = f4_sub(corner[k], f4_set1(apex[k]));
        edge[k] = f4_sub(f4_next(corner[k]), corner[k]);    /* b - a, c - b, a - c, b - a */
        sum[k] = f4_join(f4_add(to, f4_next(to)), edge[k]); /* the normal is (a - c) x (b - a) */
        length[k] = f4_abs(edge[k]);
        magnitude[k] = f4_join(f4_max(f4_abs(sum[k]), length[k]), length[k]);
        vertex[k] = f4_last(to);
    }
    if (!MLRT_GUESS) {
        f4 size = f4_set1(SMALLEST_SIZE);
        for (int k = 0; k < 3; ++k) {
            const int p = (k + 1) % 3, q = (k + 2) % 3;
            const f4 products = f4_add(f4_mul(magnitude[p], length[q]), f4_mul(magnitude[q], length[p]));
            size = f4_add(size, f4_mul(products, f4_set1(weight[k])));
        }
        scale = f4_div(f4_set1(1), size);
    }
    f4 cross[3];
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        cross[k] = f4_sub(f4_mul(sum[p], edge[q]), f4_mul(sum[q], edge[p]));
        if (!MLRT_GUESS) cross[k] = f4_mul(cross[k], scale);
        f4_store(setup->cross[k], cross[k]);
    }
    setup->distance = vertex[0] * f4_last(cross[0]) + vertex[1] * f4_last(cross[1]) + vertex[2] * f4_last(cross[2]);
    float farthest = 0;
    for (int k = 0; k < 3; ++k) farthest = larger_of(fabsf(vertex[k]) * (1.5f - weight[k]), farthest);
    setup->distance_bound = farthest * (2 * DISTANCE_BOUND) + DISTANCE_FLOOR;
    setup->has_terms = 1;
    setup->in_plane = !MLRT_GUESS && MLRT_UNLIKELY(fabsf(setup->distance) <= setup->distance_bound) &&
                      mlrt_side_of_plane(triangle, apex) == 0;
}

#endif
