/* SPDX-License-Identifier: MIT */
/*
 * The list of all hits of one ray. They are gathered from leaves in any order and with repetitions, and then put in the
 * order of the hit rule.
 */
#ifndef MLRT_EXACT_HIT_LIST_H
#define MLRT_EXACT_HIT_LIST_H

#include "base/memory.h"
#include "exact/nearest.h"

/* The list of a worker, used for one ray after the other. All 0 = empty, with memory from malloc. */
struct mlrt_hit_list {
    struct mlrt_memory memory;
    struct mlrt_nearest *hits;
    uint32_t count;
    uint32_t capacity;
    int failed; /* 1 = a hit is missing, because there was no memory for it */
};

/* Adds a triangle if the ray hits it. */
void mlrt_gather_hit(const struct mlrt_triangles *triangles, const struct mlrt_ray_segment *ray, uint32_t number,
                     struct mlrt_hit_list *list, mlrt_counters *counters);

/* Removes repetitions: then the list has each triangle once, ascending by number. */
void mlrt_remove_repetitions(struct mlrt_hit_list *list);

/*
 * Puts the nearest `wanted` hits first, in order (rules R3, R6); the others follow in any order. Repetitions must have
 * been removed.
 */
void mlrt_order_hits(const struct mlrt_triangles *triangles, const struct mlrt_ray_segment *ray, uint32_t wanted,
                     struct mlrt_hit_list *list, mlrt_counters *counters);

void mlrt_free_hit_list(struct mlrt_hit_list *list);

#endif
