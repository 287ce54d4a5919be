/* SPDX-License-Identifier: MIT */
/*
 * All hits of one ray, gathered from leaves in any order and with repetitions, then put in the order of the hit rule.
 */
#ifndef MLRT_EXACT_HIT_LIST_H
#define MLRT_EXACT_HIT_LIST_H

#include "base/memory.h"
#include "exact/nearest.h"

/* One worker's list, used for one ray after the other. Zeroed = empty, with memory from malloc. */
struct mlrt_hit_list {
    struct mlrt_memory memory;
    struct mlrt_nearest *hits;
    uint32_t count;
    uint32_t capacity;
    int failed; /* 1 = there was no memory for a hit */
};

/* Adds a triangle if the ray hits it. */
void mlrt_gather_hit(const struct mlrt_triangle *triangles, const struct mlrt_ray_segment *ray, uint32_t number,
                     struct mlrt_hit_list *list, mlrt_counters *counters);

/* Leaves each triangle once, ascending by number. */
void mlrt_remove_repetitions(struct mlrt_hit_list *list);

/* Puts the nearest `wanted` hits first and in order (rules R3, R6); the others follow in any. No repetitions. */
void mlrt_order_hits(const struct mlrt_triangle *triangles, const struct mlrt_ray_segment *ray, uint32_t wanted,
                     struct mlrt_hit_list *list, mlrt_counters *counters);

void mlrt_free_hit_list(struct mlrt_hit_list *list);

#endif
