/* SPDX-License-Identifier: MIT */
/*
 * How far from a scene rays may begin for float. Float tells boxes, cells and triangles apart by 2^-20 of their
 * distance from the origin of a ray. So rays from more than 2^13 times the extent of the scene away would meet much
 * that they pass, and from 2^20 times everything. They go one by one in double. No answer depends on it.
 */
#ifndef MLRT_SCENE_REACH_H
#define MLRT_SCENE_REACH_H

#include <math.h>

#include "exact/triangle.h"

#define MLRT_REACH_OF_EXTENT 0x1p13f

static inline float mlrt_extent_of(const struct mlrt_box *box)
{
    float extent = box->hi[0] - box->lo[0];
    for (int k = 1; k < 3; ++k) extent = box->hi[k] - box->lo[k] > extent ? box->hi[k] - box->lo[k] : extent;
    return extent;
}

/* The greatest magnitude, at most MLRT_SAFE_MAX, that a coordinate of an origin may have for float. */
static inline float mlrt_reach_of(const struct mlrt_box *scene)
{
    float farthest = 0;
    for (int k = 0; k < 3; ++k) farthest = fmaxf(fmaxf(-scene->lo[k], scene->hi[k]), farthest);
    return fminf(farthest + MLRT_REACH_OF_EXTENT * mlrt_extent_of(scene), MLRT_SAFE_MAX);
}

#endif
