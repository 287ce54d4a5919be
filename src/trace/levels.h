/* SPDX-License-Identifier: MIT */
/*
 * The levels of the tile method: an area of 64x64 pixels is a bundle of sixteen tiles of 16x16, and a tile one of sixteen
 * packets of 4x4. Tiles and packets that one triangle covers, or nothing, are done at once; the others are cut.
 *
 * Only a camera's rays are known before they are made. Tiles of other sources begin with their packets.
 *
 * All of this decides and hands on: what looks at rays, cells and triangles is in the kernels, once per instruction
 * set.
 */
#ifndef MLRT_TRACE_LEVELS_H
#define MLRT_TRACE_LEVELS_H

#include "job/job.h"
#include "rays/rectangle.h"

/* Traces a part of a picture that starts at multiples of 4. */
void mlrt_trace_levels(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);

#endif
