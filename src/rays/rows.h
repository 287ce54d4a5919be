/* SPDX-License-Identifier: MIT */
/*
 * Finds rows of pixels in a list of rays whose caller did not say how long they are. Tiles that are squares of pixels
 * are faster than pieces of rows.
 */
#ifndef MLRT_RAYS_ROWS_H
#define MLRT_RAYS_ROWS_H

#include "rays/source.h"

/*
 * Returns the number of rays in a row, or 0 if the rays do not look like rows of pixels. A wrong answer costs speed
 * only. Reads at most a quarter of the directions (if these are equal, of the origins) and 64 more, and only a few if
 * neighbours have nothing in common. Sets the floating-point environment and restores it.
 */
uint32_t mlrt_find_row_length(const struct mlrt_source *rays);

#endif
