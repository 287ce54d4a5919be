/* SPDX-License-Identifier: MIT */
/*
 * Lanes that float filters and close_calls.h leave undecided: exact ties in one plane are found first, and the judge
 * (exact/nearest.h) decides the others, ray by ray. Compiled once for all instruction sets. `counters` is NULL except
 * in kernels that count.
 */
#ifndef MLRT_HITS_UNDECIDED_H
#define MLRT_HITS_UNDECIDED_H

#include "exact/nearest.h"
#include "job/job.h"

/* Empties the worker's table of planes, and sets its length, 1 << plane_bits. */
void mlrt_forget_planes(uint32_t plane_bits, struct mlrt_worker *worker);

/* Do two triangles lie in one plane? If so, the worker keeps the answer, since neighbouring rays need the same one. */
int mlrt_have_one_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker);

/* The triangle that represents the plane of a triangle, by the worker's table (undecided.c). */
static inline uint32_t mlrt_known_plane_of(const struct mlrt_worker *worker, uint32_t number)
{
    for (;;) {
        const struct mlrt_known_plane *known = &worker->known.planes[number & worker->known.plane_mask];
        if (known->number != number) return number;
        number = known->plane;
    }
}

/*
 * Settles the ties of those of `lanes` whose nearest hits lie in the plane of triangle `number`: by comparing
 * triangles, or without a tree, as far as the worker's table knows. Returns the lanes that are settled.
 */
uint32_t mlrt_settle_ties(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                          struct mlrt_packet *packet, struct mlrt_worker *worker);

/*
 * Decides whether the rays in `lanes` hit a triangle; those in `inside` are known to be inside its edges. Returns the
 * lanes whose nearest hit is nearer than before. (A tie may change the triangle without changing the distance.)
 */
uint32_t mlrt_decide_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                           struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters);

#endif
