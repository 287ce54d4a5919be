/* SPDX-License-Identifier: MIT */
/*
 * Rows of pixels in a list of rays whose caller did not say how long they are. Squares of neighbours are faster than
 * pieces of rows.
 */
#ifndef MLRT_RAYS_ROWS_H
#define MLRT_RAYS_ROWS_H

#include "rays/source.h"

/*
 * The number of rays in a row, or 0 if the rays do not look like rows. Right or wrong, it changes nothing but speed. It
 * looks at no more than a quarter of the directions, or of the origins where the directions are equal; where neighbours
 * have nothing in common, at a few.
 */
uint32_t mlrt_find_row_length(const struct mlrt_source *rays);

#endif
