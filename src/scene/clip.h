/* SPDX-License-Identifier: MIT */
/*
 * Bounds of the part of a triangle that lies in a box ("perfect splits").
 *
 * Bounds always hold every point that the triangle, in exact arithmetic, shares with the closed box, and lie in the
 * box. They are as tight as double arithmetic shows, rounded outward to float. Coordinates are finite; any magnitude
 * will do.
 */
#ifndef MLRT_SCENE_CLIP_H
#define MLRT_SCENE_CLIP_H

#include "exact/triangle.h"

/* Two boxes, below and above a plane, and which of the two the triangle can touch. */
struct mlrt_halves {
    struct mlrt_box box[2];
    int touched[2];
};

/*
 * Cuts `box` by the plane x_axis = position, which must not lie outside it, and bounds the triangle in both halves. A
 * half that is not `touched` has no point in common with the triangle, and its box is not set.
 *
 * New coordinates with a magnitude under `tiny` are moved outward to 0 or to +-tiny; 0 = all floats are good.
 */
void mlrt_clip_halves(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis, float position,
                      float tiny, struct mlrt_halves *halves);

/* The area of the triangle's part in `box`, seen along `axis`, with the accuracy of double arithmetic. */
double mlrt_clipped_area(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis);

#endif
