/* SPDX-License-Identifier: MIT */
/* Writes what takes no vectors to all sinks of a worker, which are a frame and a callback's arrays. Compiled once. */
#ifndef MLRT_HITS_WRITE_TO_SINKS_H
#define MLRT_HITS_WRITE_TO_SINKS_H

#include "job/job.h"
#include "rays/rectangle.h"

/* Writes misses to a rectangle of a picture. */
void mlrt_write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
                               const struct mlrt_rectangle *tile);

/* Writes one value of `occluded` to a rectangle of a picture. */
void mlrt_write_picture_shadow(const struct mlrt_worker *worker, uint8_t shadow, const struct mlrt_rectangle *tile);

/* Writes the lights that do not reach the hits of a packet's lanes. */
void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block);

#endif
