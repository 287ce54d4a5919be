/* SPDX-License-Identifier: MIT */
/*
 * What is left of close calls: exact ties in one plane, and then the judge, ray by ray (nearest.h). Compiled once, for all
 * instruction sets: `counters` are NULL but for kernels that count. close_calls.h decides what it can before.
 */
#ifndef MLRT_HITS_UNDECIDED_H
#define MLRT_HITS_UNDECIDED_H

#include "job/job.h"

/* Empties what a worker remembers of planes and pairs, of which there is room for 1 << bits. */
void mlrt_forget_planes(uint32_t plane_bits, uint32_t pair_bits, struct mlrt_worker *worker);

/* Do two triangles lie in one plane? A worker remembers the last answers, since neighbours ask the same. */
int mlrt_have_one_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker);

/* The triangle that stands for the plane of a triangle, as far as is known (undecided.c). */
static inline uint32_t mlrt_known_plane_of(const struct mlrt_worker *worker, uint32_t number)
{
    for (;;) {
        const struct mlrt_known_plane *known = &worker->planes[number & worker->plane_mask];
        if (known->number != number) return number;
        number = known->plane;
    }
}

static inline struct mlrt_triangle_pair *mlrt_pair_of(const struct mlrt_worker *worker, uint32_t first, uint32_t second)
{
    return &worker->pairs[(first ^ second) & worker->pair_mask];
}

static inline int mlrt_is_pair(const struct mlrt_triangle_pair *pair, uint32_t first, uint32_t second)
{
    return pair->first == first && pair->second == second;
}

/* Makes a pair of the triangles, with their order from an apex. */
void mlrt_find_order(const struct mlrt_tree *tree, const float apex[3], uint32_t first, uint32_t second,
                     struct mlrt_triangle_pair *pair);

/* The order of two triangles from an apex (predicate.h: mlrt_order_of_triangles). */
static inline int mlrt_known_order(const struct mlrt_tree *tree, const float apex[3], uint32_t first, uint32_t second,
                                   struct mlrt_worker *worker)
{
    struct mlrt_triangle_pair *pair = mlrt_pair_of(worker, first, second);
    if (MLRT_UNLIKELY(!mlrt_is_pair(pair, first, second) || pair->apex[0] != apex[0] || pair->apex[1] != apex[1] ||
                      pair->apex[2] != apex[2])) {
        mlrt_find_order(tree, apex, first, second, pair);
    }
    return pair->order;
}

/*
 * Exact ties are common: things drawn twice, walls of one plane. Where the nearest hit so far lies in the plane of the
 * triangle, so does the ray's hit of it: at the same t, which is known to be in range. So the later of the two in the
 * input changes nothing, whether it is hit or not, and the earlier one replaces the other where it is surely inside.
 * Returns the lanes of `lanes`, whose nearest hit is `nearest`, that this settles.
 */
static inline uint32_t mlrt_settle_tie(uint32_t number, uint32_t nearest, uint32_t lanes, uint32_t inside,
                                       struct mlrt_packet *packet)
{
    if (number > nearest) return lanes;
    lanes &= inside;
    for (uint32_t left = lanes; left; left &= left - 1) packet->triangle[mlrt_lowest_bit(left)] = number;
    return lanes;
}

/* Offers a triangle to the rays in `lanes`, of which those in `inside` are surely inside its edges. Returns the lanes
 * that are hit nearer than before: not those where only the triangle is another, at the same distance. */
uint32_t mlrt_decide_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                           struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters);

/* Offers those of the triangles numbers[i] for which bit i is set to one ray. Returns 1 if one of
 * them became the nearest hit, which for a job that looks for any is the last one offered. */
int mlrt_decide_triangles(const struct mlrt_job *job, const uint32_t *numbers, uint32_t undecided, uint32_t inside,
                          uint32_t lane, struct mlrt_packet *packet, struct mlrt_worker *worker,
                          mlrt_counters *counters);

#endif
