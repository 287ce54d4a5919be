/* SPDX-License-Identifier: MIT */
/*
 * Where rays come from: reading them out of the caller's arrays, one by one and sixteen at a time.
 */
#include "source.h"

#include <math.h>
#include <string.h>

#include "hit.h"

/* ---- checking ---- */

/* Resolves a packed stride; 0 if the array cannot be read as 4-byte numbers. */
static int resolve_array(const mlrt_const_array *array, size_t element_size, int required, mlrt_const_array *resolved)
{
    *resolved = *array;
    if (!array->data) return !required;
    if (resolved->stride == 0) resolved->stride = element_size;
    return resolved->stride % 4 == 0 && (uintptr_t)array->data % 4 == 0;
}

static int32_t set_extent(struct mlrt_source *source, size_t count, uint32_t row_length)
{
    if (count > INT32_MAX) return MLRT_ERROR_TOO_LARGE;
    source->count = (uint32_t)count;
    source->width = row_length ? row_length : 4;
    if (source->width > source->count && source->count > 4) source->width = source->count;
    source->height = source->count / source->width + (source->count % source->width != 0);
    return MLRT_OK;
}

int32_t mlrt_make_view_source(const mlrt_camera *camera, struct mlrt_source *source)
{
    source->kind = MLRT_SOURCE_CAMERA;
    int32_t status = mlrt_make_view(camera, &source->view);
    if (status != MLRT_OK) return status;
    source->width = source->view.width;
    source->height = source->view.height;
    source->count = source->width * source->height;
    return MLRT_OK;
}

int32_t mlrt_make_ray_source(const struct mlrt_tree *tree, const mlrt_rays *rays, struct mlrt_source *source)
{
    source->kind = MLRT_SOURCE_RAYS;
    source->tree = tree;
    const int required = rays->count > 0;
    if (!resolve_array(&rays->origins, 12, required, &source->points) ||
        !resolve_array(&rays->directions, 12, required, &source->directions) ||
        !resolve_array(&rays->t_min, 4, 0, &source->t_min) || !resolve_array(&rays->t_max, 4, 0, &source->t_max) ||
        !resolve_array(&rays->skip, 8, 0, &source->skip)) {
        return MLRT_ERROR_ARGUMENT;
    }
    return set_extent(source, rays->count, rays->row_length);
}

int32_t mlrt_make_light_source(const struct mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                               struct mlrt_source *source)
{
    if (light->kind != MLRT_LIGHT_POINT && light->kind != MLRT_LIGHT_DIRECTIONAL) return MLRT_ERROR_ARGUMENT;
    source->kind = light->kind == MLRT_LIGHT_POINT ? MLRT_SOURCE_POINT_LIGHT : MLRT_SOURCE_DIRECTIONAL_LIGHT;
    source->tree = tree;
    for (int k = 0; k < 3; ++k) {
        if (!isfinite(light->position[k])) return MLRT_ERROR_ARGUMENT;
        source->light[k] = light->position[k];
    }
    if (!resolve_array(&points->positions, 12, points->count > 0, &source->points) ||
        !resolve_array(&points->skip, 8, 0, &source->skip)) {
        return MLRT_ERROR_ARGUMENT;
    }
    return set_extent(source, points->count, points->row_length);
}

/* ---- reading rays ---- */

static const float *float_at(const mlrt_const_array *array, uint32_t i)
{
    return (const float *)(const void *)((const unsigned char *)array->data + (size_t)i * array->stride);
}

uint32_t mlrt_triangle_number(const struct mlrt_tree *tree, uint32_t mesh_id, uint32_t triangle)
{
    uint32_t below = 0, above = tree->mesh_count;
    while (below < above) {
        uint32_t middle = below + (above - below) / 2;
        if (tree->mesh_ids[tree->mesh_by_id[middle]] < mesh_id) {
            below = middle + 1;
        } else {
            above = middle;
        }
    }
    if (below == tree->mesh_count) return MLRT_NONE;
    uint32_t mesh = tree->mesh_by_id[below];
    if (tree->mesh_ids[mesh] != mesh_id) return MLRT_NONE;
    return triangle < tree->mesh_first[mesh + 1] - tree->mesh_first[mesh] ? tree->mesh_first[mesh] + triangle
                                                                          : MLRT_NONE;
}

static uint32_t skip_at(const struct mlrt_source *source, uint32_t i)
{
    if (!source->skip.data) return MLRT_NONE;
    const uint32_t *pair =
        (const uint32_t *)(const void *)((const unsigned char *)source->skip.data + (size_t)i * source->skip.stride);
    return mlrt_triangle_number(source->tree, pair[0], pair[1]);
}

static int get_camera_ray(const struct mlrt_view *view, uint32_t x, uint32_t y, struct mlrt_ray_segment *ray)
{
    float p[3];
    mlrt_view_point(view, x, y, p);
    return view->parallel ? mlrt_make_segment(p, view->direction, view->t_min, view->t_max, ray)
                          : mlrt_make_segment(view->eye, p, view->t_min, view->t_max, ray);
}

int mlrt_get_ray(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_ray_segment *ray, uint32_t *skip)
{
    if (skip) *skip = MLRT_NONE;
    if (source->kind == MLRT_SOURCE_CAMERA) return get_camera_ray(&source->view, x, y, ray);

    const uint64_t position = (uint64_t)y * source->width + x;
    if (position >= source->count) return 0;
    const uint32_t i = (uint32_t)position;
    const float *point = float_at(&source->points, i);
    if (skip) *skip = skip_at(source, i);
    if (source->kind == MLRT_SOURCE_RAYS) {
        return mlrt_make_segment(point, float_at(&source->directions, i),
                                 source->t_min.data ? *float_at(&source->t_min, i) : 0,
                                 source->t_max.data ? *float_at(&source->t_max, i) : INFINITY, ray);
    }
    if (source->kind == MLRT_SOURCE_DIRECTIONAL_LIGHT) return mlrt_make_segment(point, source->light, 0, INFINITY, ray);
    const float direction[3] = {point[0] - source->light[0], point[1] - source->light[1], point[2] - source->light[2]};
    return mlrt_make_segment(source->light, direction, 0, 1, ray);
}

/* ---- packets ---- */

void mlrt_get_packet(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                     struct mlrt_packet *packet)
{
    packet->active = packet->single = 0;
    packet->has_apex = 1;
    packet->has_skip = source->skip.data != NULL;
    const uint32_t lanes = mlrt_block_lanes(width, height);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        struct mlrt_ray_segment ray;
        uint32_t skip = MLRT_NONE;
        const int valid = (lanes >> lane & 1) && mlrt_get_ray(source, x + (uint32_t)mlrt_lane_x[lane],
                                                              y + (uint32_t)mlrt_lane_y[lane], &ray, &skip);
        if (!valid) ray = (struct mlrt_ray_segment){{0, 0, 0}, {0, 0, 0}, 0, 0};
        for (int k = 0; k < 3; ++k) {
            packet->origin[k][lane] = ray.origin[k];
            packet->direction[k][lane] = ray.direction[k];
        }
        packet->t_min[lane] = ray.t_min;
        packet->t_max[lane] = packet->lo[lane] = packet->hi[lane] = ray.t_max;
        packet->triangle[lane] = MLRT_NONE;
        packet->skip[lane] = skip;
        if (!valid) continue;
        if (!(packet->active | packet->single)) memcpy(packet->apex, ray.origin, sizeof packet->apex);
        packet->has_apex &= memcmp(packet->apex, ray.origin, sizeof packet->apex) == 0;
        if (mlrt_is_safe_ray(&ray)) {
            packet->active |= 1u << lane;
        } else {
            packet->single |= 1u << lane;
        }
    }
}
