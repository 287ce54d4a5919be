/* SPDX-License-Identifier: MIT */
/*
 * The levels of the tile method: an area of 64x64 pixels is sixteen cells of 16x16, and one of those sixteen packets of
 * 4x4. Cells that one triangle covers, or nothing, are done at once; the others are cut.
 *
 * Only a camera's rays are known before they are made. Tiles of other sources begin with their packets.
 *
 * All of this decides and hands on: what looks at rays, cells and triangles is in the kernels, once per instruction
 * set.
 */
#ifndef MLRT_LEVELS_H
#define MLRT_LEVELS_H

#include "tile.h"

/* Traces a part of a picture that starts at multiples of 4. */
void mlrt_trace_levels(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);

/*
 * Before four rows of a tile are read, has the next four of it, and as many of the next tile, brought into the cache.
 * Rows of a picture lie too far apart for the processor to foresee, and it has few misses under way at once, so they
 * come a little at a time; lists are read in order.
 */
void mlrt_prefetch_around(const struct mlrt_source *source, const struct mlrt_rectangle *tile, uint32_t row);

#endif
