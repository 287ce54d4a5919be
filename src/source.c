/* SPDX-License-Identifier: MIT */
/*
 * Where rays come from: reading them out of the caller's arrays, one by one and sixteen at a time.
 *
 * Elements are fetched one by one, since arrays are aligned to 4 bytes only and have any stride. What is known of all
 * sixteen rays is found on vectors (kernels/packet_check.h).
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

/*
 * The elements of the rays of a block. Lanes that do not exist get that of the block's first ray, which does: nothing
 * may be read beside the elements.
 */
static void find_elements(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                          uint32_t elements[MLRT_PACKET_RAYS])
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const uint32_t column = (lane & 1) | (lane >> 1 & 2), row = (lane >> 1 & 1) | (lane >> 2 & 2);
        const uint32_t offset = lanes >> lane & 1 ? row * source->width + column : 0;
        elements[lane] = y * source->width + x + offset;
    }
}

static void fetch_vectors(const mlrt_const_array *array, const uint32_t elements[MLRT_PACKET_RAYS],
                          float vectors[3][MLRT_PACKET_RAYS])
{
    for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const float *vector = float_at(array, elements[lane]);
        for (int k = 0; k < 3; ++k) vectors[k][lane] = vector[k];
    }
}

static void fill(float value, float numbers[MLRT_PACKET_RAYS])
{
    for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) numbers[lane] = value;
}

/* Numbers out of an array, or `standard` if there is none. */
static void fetch_numbers(const mlrt_const_array *array, const uint32_t elements[MLRT_PACKET_RAYS], float standard,
                          float numbers[MLRT_PACKET_RAYS])
{
    if (!array->data) {
        fill(standard, numbers);
        return;
    }
    for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) numbers[lane] = *float_at(array, elements[lane]);
}

static void fetch_camera_rays(const struct mlrt_view *view, uint32_t x, uint32_t y, struct mlrt_packet *packet)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        float p[3];
        mlrt_view_point(view, x + (uint32_t)mlrt_lane_x[lane], y + (uint32_t)mlrt_lane_y[lane], p);
        for (int k = 0; k < 3; ++k) {
            packet->origin[k][lane] = view->parallel ? p[k] : view->eye[k];
            packet->direction[k][lane] = view->parallel ? view->direction[k] : p[k];
        }
    }
    fill(view->t_min, packet->t_min);
    fill(view->t_max, packet->t_max);
}

/* Of the points, which are where the origins go. */
static void set_light_rays(const struct mlrt_source *source, struct mlrt_packet *packet)
{
    const int is_point = source->kind == MLRT_SOURCE_POINT_LIGHT;
    for (int k = 0; k < 3; ++k) {
        for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
            const float light = source->light[k], point = packet->origin[k][lane];
            packet->direction[k][lane] = is_point ? point - light : light;
            packet->origin[k][lane] = is_point ? light : point;
        }
    }
    fill(0, packet->t_min);
    fill(is_point ? 1 : INFINITY, packet->t_max);
}

void mlrt_fetch_packet(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                       struct mlrt_packet *packet)
{
    packet->has_skip = 0;
    if (source->kind == MLRT_SOURCE_CAMERA) {
        fetch_camera_rays(&source->view, x, y, packet);
        return;
    }
    uint32_t elements[MLRT_PACKET_RAYS];
    find_elements(source, x, y, lanes, elements);
    fetch_vectors(&source->points, elements, packet->origin);
    if (source->kind == MLRT_SOURCE_RAYS) {
        fetch_vectors(&source->directions, elements, packet->direction);
        fetch_numbers(&source->t_min, elements, 0, packet->t_min);
        fetch_numbers(&source->t_max, elements, INFINITY, packet->t_max);
    } else {
        set_light_rays(source, packet);
    }
    packet->has_skip = source->skip.data != NULL;
    for (int lane = 0; packet->has_skip && lane < MLRT_PACKET_RAYS; ++lane) {
        packet->skip[lane] = skip_at(source, elements[lane]);
    }
}
