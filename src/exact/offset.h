/* SPDX-License-Identifier: MIT */
/* Points just off a triangle, on a given side. */
#ifndef MLRT_EXACT_OFFSET_H
#define MLRT_EXACT_OFFSET_H

#include "exact/triangle.h"

/*
 * Sets `point` to a point near (1 - u - v) a + u b + v c, strictly on the side of the normal (side = +1) or on the
 * other (-1). Unless `from` is NULL, `point` is relative to it: `from` + `point` is such a point, a sum that is not
 * rounded. Returns 0 if none is found in the range of float, if u or v is not finite, or if the triangle is not finite
 * or has no area.
 */
int mlrt_find_offset_point(const struct mlrt_triangle *triangle, float u, float v, int side, const float *from,
                           float point[3]);

#endif
