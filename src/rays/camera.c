/* SPDX-License-Identifier: MIT */
/* The check of a camera. The formula of its rays is in camera.h. */
#include "rays/camera.h"

#include <math.h>

#include "base/structs.h"

/* Up to here float holds the number of a column or row exactly, and its sum with 0.5. */
#define PIXEL_LIMIT (1u << 23)

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

/* Checks a length of the picture, and resolves that of its crop along the same axis. Returns a status. */
static int32_t resolve_length(const char *axis, const char *length, uint32_t whole, uint32_t first, uint32_t count,
                              uint32_t *resolved)
{
    *resolved = count ? count : whole - first;
    if (whole == 0 || whole > PIXEL_LIMIT) {
        return mlrt_fail(whole ? MLRT_ERROR_TOO_LARGE : MLRT_ERROR_CAMERA, "camera.%s: %lu is not from 1 to %lu",
                         length, (unsigned long)whole, (unsigned long)PIXEL_LIMIT);
    }
    if (first >= whole) {
        return mlrt_fail(MLRT_ERROR_CAMERA, "camera.crop_%s: %lu is not less than %s %lu", axis, (unsigned long)first,
                         length, (unsigned long)whole);
    }
    if (count <= whole - first) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_CAMERA, "camera.crop_%s: %lu from crop_%s %lu on is more than %s %lu", length,
                     (unsigned long)count, axis, (unsigned long)first, length, (unsigned long)whole);
}

static int32_t check_numbers(const mlrt_camera *camera)
{
    const int is_parallel = mlrt_is_parallel(camera);
    int32_t status = is_parallel ? mlrt_check_fields(MLRT_FORM_DIRECTION, "camera", 0, camera) : MLRT_OK;
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_VIEW, "camera", 0, camera);
    if (status == MLRT_OK && !is_parallel) status = mlrt_check_fields(MLRT_FORM_EYE, "camera", 0, camera);
    if (status != MLRT_OK) return status;
    if (is_parallel && is_zero_vector(camera->direction))
        return mlrt_fail(MLRT_ERROR_CAMERA, "camera.direction: all of it is 0");
    if (spans_plane(camera->dx, camera->dy)) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_CAMERA, "camera.dx: it is parallel to dy, or one of them is 0");
}

int32_t mlrt_make_view(const mlrt_camera *camera, mlrt_camera *view)
{
    *view = *camera;
    int32_t status = resolve_length("x", "width", camera->width, camera->crop_x, camera->crop_width, &view->crop_width);
    if (status == MLRT_OK)
        status = resolve_length("y", "height", camera->height, camera->crop_y, camera->crop_height, &view->crop_height);
    if (status == MLRT_OK && (uint64_t)view->crop_width * view->crop_height > INT32_MAX) {
        status =
            mlrt_fail(MLRT_ERROR_TOO_LARGE, "camera.crop_width: %lu x crop_height %lu are more pixels than 2147483647",
                      (unsigned long)view->crop_width, (unsigned long)view->crop_height);
    }
    if (status == MLRT_OK) status = check_numbers(camera);
    if (status != MLRT_OK) return status;
    for (int k = 0; k < 3; ++k) view->direction[k] = camera->direction[k] + 0.0f; /* -0 becomes 0 */
    view->t_min = camera->t_min < 0 ? 0 : camera->t_min;
    /* 0 stands for no limit. A t_max below 0 allows no hit and becomes 0: -inf would pass for no limit. */
    view->t_max = camera->t_max == 0 ? INFINITY : camera->t_max < 0 ? 0 : camera->t_max;
    return MLRT_OK;
}
