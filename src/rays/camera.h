/* SPDX-License-Identifier: MIT */
/* The camera: the formula that makes the ray of a pixel (rule R7). */
#ifndef MLRT_RAYS_CAMERA_H
#define MLRT_RAYS_CAMERA_H

#include "mlrt.h"

/*
 * A view is a camera that was checked, with its defaults resolved: the size of the crop, t_min >= 0, and a t_max that
 * is inf without a limit. Pixel (0, 0) is the first of the crop.
 *
 * Sets the view of a camera, whose struct_size is right. Returns a status.
 */
int32_t mlrt_make_view(const mlrt_camera *camera, mlrt_camera *view);

static inline int mlrt_is_parallel(const mlrt_camera *view)
{
    return view->projection == MLRT_PROJECTION_PARALLEL;
}

/* fl(first + i + sample): where column or row i of the crop is sampled. first + i is exact in float. */
static inline float mlrt_sample_position(uint32_t first, uint32_t i, float sample)
{
    return (float)(first + i) + sample;
}

/* The vector p of a pixel: the direction of a pinhole camera's ray, the origin of a parallel camera's. */
static inline void mlrt_view_point(const mlrt_camera *view, uint32_t i, uint32_t j, float p[3])
{
    const float x = mlrt_sample_position(view->crop_x, i, view->sample_x);
    const float y = mlrt_sample_position(view->crop_y, j, view->sample_y);
    for (int k = 0; k < 3; ++k) p[k] = (view->d00[k] + x * view->dx[k]) + y * view->dy[k];
}

#endif
