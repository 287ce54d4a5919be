/* SPDX-License-Identifier: MIT */
/*
 * The steps around the traversal that are compiled once: rays that are traced one by one in double, and results without
 * rays, which are written to frame and callback.
 */
#ifndef MLRT_HITS_FINISH_H
#define MLRT_HITS_FINISH_H

#include "job/job.h"
#include "rays/rectangle.h"

/*
 * Traces lanes of a packet one by one in double, and stores the triangles that they hit; none if the call is to end.
 * `counters` may be NULL.
 */
void mlrt_trace_in_double(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                          struct mlrt_worker *worker, mlrt_counters *counters);

/* Writes misses to a rectangle of a picture. */
void mlrt_write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
                               const struct mlrt_rectangle *tile);

/* Writes one value of `occluded` to a rectangle of a picture. */
void mlrt_write_picture_shadow(const struct mlrt_worker *worker, uint8_t shadow, const struct mlrt_rectangle *tile);

/* Writes the lights that do not reach the hits of a packet's lanes. */
void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block);

#endif
