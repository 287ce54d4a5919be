/* SPDX-License-Identifier: MIT */
/* Hits one at a time: an mlrt_hit for a ray and the number of a triangle, and lists of them in the caller's arrays. */
#ifndef MLRT_JOB_SET_HIT_H
#define MLRT_JOB_SET_HIT_H

#include "exact/quotients.h"
#include "rays/lone_ray.h"
#include "scene/tree.h"

/*
 * Sets all fields of a hit, `occluded` to 0, for triangle `number`; those of a miss for MLRT_NONE. The judge computes
 * the numbers that `outputs` asks for; the others have no meaning.
 */
void mlrt_set_hit(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t number, uint32_t outputs,
                  mlrt_hit *hit);

/* Sets the fields of a hit that a ray's query writes, for triangle `number`; a miss for MLRT_NONE. */
void mlrt_set_result(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, uint32_t number, mlrt_hit *hit);

/* Writes `count` hits to all arrays of a list, which were checked, from element `first` on. */
void mlrt_write_hits(const mlrt_hit *hits, size_t first, uint32_t count, const mlrt_hits *list);

#endif
