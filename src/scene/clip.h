/* SPDX-License-Identifier: MIT */
/*
 * Bounds of the part of a triangle that lies in a box ("perfect splits").
 *
 * The bounds lie in the box and hold every point that the triangle, in exact arithmetic, shares with the closed box.
 * They are as tight as double arithmetic can tell, rounded outward to float. Coordinates are finite, of any magnitude.
 */
#ifndef MLRT_SCENE_CLIP_H
#define MLRT_SCENE_CLIP_H

#include "exact/triangle.h"

/* Two boxes, below and above a plane. touched[i]: the triangle can have a point in box[i]. */
struct mlrt_halves {
    struct mlrt_box box[2];
    int touched[2];
};

/*
 * Cuts `box` by the plane x_axis = position, which must not lie outside it, and bounds the triangle in both halves. A
 * half that is not `touched` has no point in common with the triangle, and its box is undefined.
 *
 * New coordinates with a magnitude below `tiny` are rounded outward to 0, `tiny` or -`tiny`. 0: to any float.
 */
void mlrt_clip_halves(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis, float position,
                      float tiny, struct mlrt_halves *halves);

/* The area, projected along `axis`, of the part of the triangle in `box`, with the accuracy of double arithmetic. */
double mlrt_clipped_area(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis);

#endif
