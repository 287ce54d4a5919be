/* SPDX-License-Identifier: MIT */
/*
 * What is left of close calls: exact ties in one plane, and then the judge, ray by ray (hit.h). Compiled once, for all
 * instruction sets: `counters` are NULL but for kernels that count. kernels/close_calls.h decides what it can before.
 */
#ifndef MLRT_UNDECIDED_H
#define MLRT_UNDECIDED_H

#include "kernels.h"

/* Empties what a worker remembers of planes, of which it has room for 1 << bits triangles. */
void mlrt_forget_planes(uint32_t bits, struct mlrt_worker *worker);

/* Do two triangles lie in one plane? A worker remembers the last answers, since neighbours ask the same. */
int mlrt_have_one_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker);

/*
 * Settles ties without arithmetic: where the nearest hit of a lane is known to lie in the plane of the triangle. Returns
 * the lanes of `lanes` that are settled, as they are offered to mlrt_decide_lanes.
 */
uint32_t mlrt_settle_known_ties(uint32_t number, uint32_t lanes, uint32_t inside, struct mlrt_packet *packet,
                                const struct mlrt_worker *worker);

/* Offers a triangle to the rays in `lanes`, of which those in `inside` are surely inside its edges. Returns the lanes
 * that are hit nearer than before: not those where only the triangle is another, at the same distance. */
uint32_t mlrt_decide_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                           struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters);

/* Offers those of the triangles numbers[i] for which bit i is set to one ray, which has no shear. Returns 1 if one of
 * them became the nearest hit, which for a job that looks for any is the last one offered. */
int mlrt_decide_triangles(const struct mlrt_job *job, const uint32_t *numbers, uint32_t undecided, uint32_t inside,
                          uint32_t lane, struct mlrt_packet *packet, struct mlrt_worker *worker,
                          mlrt_counters *counters);

#endif
