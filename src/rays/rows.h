/* SPDX-License-Identifier: MIT */
/*
 * Finds rows of pixels in a list of rays whose caller did not say how long they are. Tiles that are squares of pixels
 * are faster than pieces of rows.
 */
#ifndef MLRT_RAYS_ROWS_H
#define MLRT_RAYS_ROWS_H

#include "rays/source.h"

/*
 * Returns the number of rays in a row, or 0 if the rays are closer together as the list that they are. A wrong answer
 * costs speed only. Reads a few hundred rays, if there are as many. Sets the floating-point environment and restores
 * it.
 */
uint32_t mlrt_find_row_length(const struct mlrt_source *rays);

#endif
