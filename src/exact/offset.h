/* SPDX-License-Identifier: MIT */
/*
 * Points just off a triangle, on a side that is certain.
 */
#ifndef MLRT_EXACT_OFFSET_H
#define MLRT_EXACT_OFFSET_H

#include "exact/triangle.h"

/*
 * A point near (1 - u - v) a + u b + v c, strictly on the side of the normal (side = +1) or the other (-1). 0 if there
 * is none in the range of float, if u or v is not finite, or if the triangle has no plane.
 */
int mlrt_find_offset_point(const struct mlrt_triangle *triangle, float u, float v, int side, float point[3]);

/* Likewise such a point as seen from `from`: what has to be added to that, without rounding, to come to it. */
int mlrt_find_offset_from(const struct mlrt_triangle *triangle, float u, float v, int side, const float from[3],
                          float by[3]);

#endif
