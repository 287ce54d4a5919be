/* SPDX-License-Identifier: MIT */
/*
 * The steps around the traversal that are compiled once: rays that are traced one by one in double, and results of
 * packets and of whole rectangles, which are written to frame and callback.
 */
#ifndef MLRT_HITS_FINISH_H
#define MLRT_HITS_FINISH_H

#include "job/job.h"
#include "rays/rectangle.h"

/* Makes the rays of a block, and checks them. `lanes` are those that exist. */
static inline void mlrt_get_packet(const struct mlrt_job *job, const struct mlrt_rectangle *block, uint32_t lanes,
                                   struct mlrt_packet *packet)
{
    job->kernels->picture->fetch_block(&job->source, block, lanes, packet);
    job->kernels->picture->check_block(&job->source, lanes, packet);
}

/* Traces lanes of a packet one by one in double, and stores the triangles that they hit. */
void mlrt_trace_single_rays(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                            mlrt_counters *counters);

/*
 * Writes hits of one triangle to a rectangle of a picture, or misses if `cover` is MLRT_NONE. With hits, a picture with
 * lights keeps its values of `occluded`.
 */
void mlrt_write_closed(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t cover,
                       const struct mlrt_rectangle *tile);

/* Writes one value of `occluded` to a rectangle of a picture. */
void mlrt_write_picture_shadow(const struct mlrt_worker *worker, uint8_t shadow, const struct mlrt_rectangle *tile);

/* Writes the lights that do not reach the hits of a packet's lanes. */
void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block);

/* Traces the single rays of a packet, and writes the results of all, and their shadows. */
void mlrt_end_packet(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t lanes,
                     const struct mlrt_rectangle *block, struct mlrt_packet *packet);

/* Traces the blocks of 4x4 rays of a tile. `list` is that of the kd-tree's blocks. */
void mlrt_trace_blocks(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile,
                       const struct entry_list *list, mlrt_trace_block *trace_block);

/* trace_tile (job/job.h) of MLRT_METHOD_RAY: traces all rays of a tile one by one in double. It counts. */
void mlrt_trace_by_rays(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *tile);

#endif
