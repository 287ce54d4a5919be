/* SPDX-License-Identifier: MIT */
/*
 * Rays that the library makes for callers, who trace them as their own: a camera's, and those that leave a hit, to a
 * light or anywhere.
 */
#include <math.h>
#include <string.h>

#include "api/arguments.h"
#include "exact/offset.h"
#include "exact/predicate.h"
#include "hits/shadow_ray.h"
#include "rays/camera.h"
#include "rays/lone_ray.h"
#include "rays/source.h"
#include "scene/triangle_numbers.h"

static float *vector_at(const mlrt_array *array, uint32_t width, uint32_t i, uint32_t j)
{
    const size_t stride = array->stride ? array->stride : 12;
    const size_t row_stride = array->row_stride ? array->row_stride : width * stride;
    return (float *)(void *)((unsigned char *)array->data + j * row_stride + i * stride);
}

static MLRT_NOINLINE int32_t write_camera_rays(const mlrt_camera *camera, const mlrt_array *origins,
                                               const mlrt_array *directions)
{
    mlrt_camera view;
    const int32_t status = mlrt_make_view(camera, &view);
    if (status != MLRT_OK) return status;
    for (uint32_t j = 0; j < view.crop_height; ++j) {
        for (uint32_t i = 0; i < view.crop_width; ++i) {
            float p[3];
            mlrt_view_point(&view, i, j, p);
            if (origins->data)
                memcpy(vector_at(origins, view.crop_width, i, j), mlrt_is_parallel(&view) ? p : view.eye, sizeof p);
            if (directions->data)
                memcpy(vector_at(directions, view.crop_width, i, j), mlrt_is_parallel(&view) ? camera->direction : p,
                       sizeof p);
        }
    }
    return MLRT_OK;
}

MLRT_API int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions)
{
    static const mlrt_array none;
    const mlrt_array *const vectors[2] = {origins ? origins : &none, directions ? directions : &none};
    mlrt_camera own;
    if (!camera) return mlrt_fail_null("camera", 0);
    int32_t status = mlrt_take_struct(MLRT_STRUCT_CAMERA, "camera", 0, camera, &own);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_VECTORS, "origins", 0, vectors[0]);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_VECTORS, "directions", 0, vectors[1]);
    if (status != MLRT_OK) return status;
    MLRT_COMPUTE(status = write_camera_rays(&own, vectors[0], vectors[1]));
    return status;
}

/* Sets *number to that of a triangle in the tree. Returns a status: there must be one. */
static int32_t find_triangle(const mlrt_tree *tree, const char *path, uint32_t mesh, uint32_t triangle,
                             uint32_t *number)
{
    *number = mlrt_triangle_number(tree, mesh, triangle);
    if (*number != MLRT_NONE) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "%s: there is no triangle %lu in a mesh with id %lu", path,
                     (unsigned long)triangle, (unsigned long)mesh);
}

/* Sets the shadow ray from the hit of a ray to a light, and whether the light is on the ray's side of the surface. */
static MLRT_NOINLINE int32_t set_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, uint32_t number,
                                            const mlrt_light *light, mlrt_ray *shadow, int32_t *faces)
{
    struct mlrt_source source;
    struct mlrt_ray_segment segment, answer;
    int is_on_side = 0;
    mlrt_set_light(light, &source);
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    if (!mlrt_make_segment(ray->origin, ray->direction, ray->t_min, mlrt_resolve_t_max(ray), &segment) ||
        !mlrt_triangle_is_finite(&triangle) || !mlrt_hits_triangle(&segment, &triangle, NULL)) {
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "hit.triangle: the ray does not hit triangle %lu of mesh %lu",
                         (unsigned long)shadow->skip_triangle, (unsigned long)shadow->skip_mesh);
    }
    if (mlrt_make_shadow_ray(&source, &triangle, &segment, &is_on_side, &answer)) {
        memcpy(shadow->origin, answer.origin, sizeof shadow->origin);
        memcpy(shadow->direction, answer.direction, sizeof shadow->direction);
        shadow->t_max = isinf(answer.t_max) ? 0 : answer.t_max;
    }
    *faces = is_on_side;
    return MLRT_OK;
}

MLRT_API int32_t mlrt_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit,
                                 const mlrt_light *light, mlrt_ray *shadow, int32_t *faces)
{
    if (!tree || !ray || !hit || !light || !shadow || !faces) {
        return mlrt_fail_null("tree ray hit light shadow faces",
                              !tree + 2 * !ray + 4 * !hit + 8 * !light + 16 * !shadow);
    }
    mlrt_ray own_ray;
    mlrt_hit own_hit;
    mlrt_light own_light;
    uint32_t number;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_RAY, "ray", 0, ray, &own_ray);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_HIT, "hit", 0, hit, &own_hit);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_LIGHT, "light", 0, light, &own_light);
    if (status == MLRT_OK) status = mlrt_check_result_size(MLRT_STRUCT_RAY, "shadow", shadow);
    if (status == MLRT_OK) status = find_triangle(tree, "hit.triangle", own_hit.mesh, own_hit.triangle, &number);
    if (status != MLRT_OK) return status;
    mlrt_ray answer = {.struct_size = sizeof answer,
                       .flags = MLRT_RAY_SKIP,
                       .skip_mesh = own_hit.mesh,
                       .skip_triangle = own_hit.triangle};
    MLRT_COMPUTE(status = set_shadow_ray(tree, &own_ray, number, &own_light, &answer, faces));
    if (status != MLRT_OK) return status;
    mlrt_give_struct(&answer, sizeof answer, shadow);
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t find_offset_point(const mlrt_tree *tree, uint32_t number, float u, float v, int32_t side,
                                               float point[3])
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    if (mlrt_find_offset_point(&triangle, u, v, side, NULL, point)) return MLRT_OK;
    if (mlrt_triangle_is_finite(&triangle) && mlrt_triangle_has_area(&triangle))
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "point: it would leave the range of float");
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "triangle: it is not finite, or has no area");
}

MLRT_API int32_t mlrt_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float point[3])
{
    if (!tree || !point) return mlrt_fail_null("tree point", !tree);
    if (side != 1 && side != -1) return mlrt_fail(MLRT_ERROR_ARGUMENT, "side: %ld is not 1 or -1", (long)side);
    uint32_t number;
    int32_t status = find_triangle(tree, "triangle", mesh, triangle, &number);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_FLOAT, "u", 0, &u);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_FLOAT, "v", 0, &v);
    if (status != MLRT_OK) return status;
    MLRT_COMPUTE(status = find_offset_point(tree, number, u, v, side, point));
    return status;
}
