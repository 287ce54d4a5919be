/* SPDX-License-Identifier: MIT */
/* The camera: the formula that makes the ray of a pixel (rule R7). */
#ifndef MLRT_RAYS_CAMERA_H
#define MLRT_RAYS_CAMERA_H

#include "mlrt.h"

/* The part of a picture that is traced: its first pixel, and its size. */
struct mlrt_crop {
    uint32_t x;
    uint32_t y;
    uint32_t width;
    uint32_t height;
};

/* A checked camera with defaults resolved. Pixel (0, 0) is the first of the crop. */
struct mlrt_view {
    int parallel;
    struct mlrt_crop crop;
    float eye[3];       /* pinhole: every origin */
    int eye_is_safe;    /* mlrt_are_float_safe(eye) */
    float direction[3]; /* parallel: every direction */
    float d00[3];
    float dx[3];
    float dy[3];
    float sample_x;
    float sample_y;
    float t_min;
    float t_max; /* inf = no limit */
};

/* Checks a camera, whose struct_size is right, and resolves its defaults. Returns a status. */
int32_t mlrt_make_view(const mlrt_camera *camera, struct mlrt_view *view);

/* fl(first + i + sample): where column or row i of the crop is sampled. first + i is exact in float. */
static inline float mlrt_sample_position(uint32_t first, uint32_t i, float sample)
{
    return (float)(first + i) + sample;
}

/* The vector p of a pixel: the direction of a pinhole camera's ray, the origin of a parallel camera's. */
static inline void mlrt_view_point(const struct mlrt_view *view, uint32_t i, uint32_t j, float p[3])
{
    const float x = mlrt_sample_position(view->crop.x, i, view->sample_x);
    const float y = mlrt_sample_position(view->crop.y, j, view->sample_y);
    for (int k = 0; k < 3; ++k) p[k] = (view->d00[k] + x * view->dx[k]) + y * view->dy[k];
}

#endif
