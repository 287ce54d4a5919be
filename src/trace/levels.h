/* SPDX-License-Identifier: MIT */
/*
 * The levels of the tile method. A square of 64x64 pixels is a bundle of sixteen tiles of 16x16, and a tile is a bundle
 * of sixteen packets of 4x4. Tiles and packets that one triangle covers, or that meet none, are finished at once; the
 * others are cut further.
 *
 * Squares exist for cameras only, whose slopes are known before rays are made. Other sources begin with tiles.
 *
 * This file is compiled once: it calls the kernels of an instruction set, which process rays, cells and triangles.
 */
#ifndef MLRT_TRACE_LEVELS_H
#define MLRT_TRACE_LEVELS_H

#include "job/job.h"
#include "rays/rectangle.h"

/* Traces a part of a picture that starts at multiples of 4, and writes its results. */
void mlrt_trace_levels(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);

#endif
