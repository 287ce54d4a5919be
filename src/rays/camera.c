/* SPDX-License-Identifier: MIT */
/*
 * The check of a camera. The formula of its rays is in camera.h.
 */
#include "rays/camera.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

/* Up to here float holds the number of a column or row exactly, and its sum with 0.5. */
#define PIXEL_LIMIT (1u << 23)

static int is_finite_vector(const float v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

static int is_zero_vector(const float v[3])
{
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

/* 1 if the vectors are not parallel, so that they span a picture. Exact: products of two floats are, in double. */
static int spans_plane(const float a[3], const float b[3])
{
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        if ((double)a[i] * b[j] != (double)a[j] * b[i]) return 1;
    }
    return 0;
}

/* Resolves the length of a crop along one axis; 0 if it is not in the picture. */
static int crop_range(uint32_t first, uint32_t count, uint32_t whole, uint32_t *resolved)
{
    if (first >= whole || count > whole - first) return 0;
    *resolved = count ? count : whole - first;
    return 1;
}

int32_t mlrt_make_view(const mlrt_camera *camera, struct mlrt_view *view)
{
    if (camera->projection != MLRT_PROJECTION_PINHOLE && camera->projection != MLRT_PROJECTION_PARALLEL) {
        return MLRT_ERROR_ARGUMENT;
    }
    view->parallel = camera->projection == MLRT_PROJECTION_PARALLEL;
    if (camera->width == 0 || camera->height == 0) return MLRT_ERROR_CAMERA;
    if (camera->width > PIXEL_LIMIT || camera->height > PIXEL_LIMIT) return MLRT_ERROR_TOO_LARGE;
    if (!crop_range(camera->crop_x, camera->crop_width, camera->width, &view->width) ||
        !crop_range(camera->crop_y, camera->crop_height, camera->height, &view->height)) {
        return MLRT_ERROR_CAMERA;
    }
    if ((uint64_t)view->width * view->height > INT32_MAX) return MLRT_ERROR_TOO_LARGE;
    if (!is_finite_vector(camera->d00) || !is_finite_vector(camera->dx) || !is_finite_vector(camera->dy) ||
        !isfinite(camera->sample_x) || !isfinite(camera->sample_y) || isnan(camera->t_min) || isnan(camera->t_max)) {
        return MLRT_ERROR_CAMERA;
    }
    if (view->parallel) {
        if (!is_finite_vector(camera->direction) || is_zero_vector(camera->direction)) return MLRT_ERROR_CAMERA;
    } else if (!is_finite_vector(camera->eye)) {
        return MLRT_ERROR_CAMERA;
    }
    if (!spans_plane(camera->dx, camera->dy)) return MLRT_ERROR_CAMERA;

    view->first_x = camera->crop_x;
    view->first_y = camera->crop_y;
    for (int k = 0; k < 3; ++k) {
        view->eye[k] = camera->eye[k];
        view->direction[k] = camera->direction[k] + 0.0f; /* -0 becomes 0 */
        view->d00[k] = camera->d00[k];
        view->dx[k] = camera->dx[k];
        view->dy[k] = camera->dy[k];
    }
    view->sample_x = camera->sample_x;
    view->sample_y = camera->sample_y;
    view->t_min = camera->t_min < 0 ? 0 : camera->t_min;
    /* 0 stands for no limit. A t_max below 0 allows no hit and becomes 0: -inf would pass for no limit. */
    view->t_max = camera->t_max == 0 ? INFINITY : camera->t_max < 0 ? 0 : camera->t_max;
    return MLRT_OK;
}
