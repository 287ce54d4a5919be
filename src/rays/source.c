/* SPDX-License-Identifier: MIT */
/*
 * Sources of rays: reads their rays one by one, alone or into the packet of a block, element by element: arrays are
 * aligned to 4 bytes only and have any stride, and no byte outside their elements may be read. read_arrays.h reads
 * whole blocks of most arrays with vectors, fetch_block.h makes those of cameras. check_packet.h checks the rays.
 */
#include "rays/source.h"

#include <string.h>

/* ---- making sources ---- */

/* An array with its stride resolved: the bytes from element to element, or 0 if one element serves all rays. */
static mlrt_const_array resolve_array(const mlrt_const_array *array, size_t element_size)
{
    if (!array->data) return (mlrt_const_array){NULL, 0};
    const size_t stride = array->stride == 0 ? element_size : array->stride == MLRT_STRIDE_ALL ? 0 : array->stride;
    return (mlrt_const_array){array->data, stride};
}

/* 1 if the elements of two arrays lie within 63 bytes of each other, as in one struct. */
static int lie_together(const mlrt_const_array *array, const mlrt_const_array *other)
{
    const uintptr_t apart = (uintptr_t)array->data - (uintptr_t)other->data;
    return array->stride == other->stride && apart + 63 <= 126;
}

/*
 * Finds the arrays that are prefetched, of which there are none so far: those with an element for each ray; of those
 * that lie together, the first.
 */
static void find_streams(struct mlrt_ray_arrays *arrays)
{
    const mlrt_const_array *const each[5] = {&arrays->points, &arrays->directions, &arrays->t_max, &arrays->t_min,
                                             &arrays->skip};
    for (int i = 0; i < 5; ++i) {
        if (!each[i]->data || !each[i]->stride) continue;
        uint32_t j = 0;
        while (j < arrays->stream_count && !lie_together(each[i], &arrays->streams[j])) ++j;
        if (j == arrays->stream_count) arrays->streams[arrays->stream_count++] = *each[i];
    }
}

void mlrt_set_rows(uint32_t row_length, struct mlrt_source *source)
{
    source->arrays.stream_count = 0;
    source->width = 4;
    source->height = (source->count + 3) / 4;
    if (!row_length || source->arrays.rays_per_origin > 1 || source->count <= MLRT_PACKET_RAYS) return;
    source->width = row_length < source->count ? row_length : source->count;
    source->height = source->count / source->width + (source->count % source->width != 0);
    if (source->width > 4) find_streams(&source->arrays);
}

static void set_extent(struct mlrt_source *source, size_t count, uint32_t row_length)
{
    source->count = (uint32_t)count;
    mlrt_set_rows(row_length, source);
}

int32_t mlrt_make_view_source(const mlrt_camera *camera, struct mlrt_source *source)
{
    source->kind = MLRT_SOURCE_CAMERA;
    source->arrays.rays_per_origin = 1;
    source->arrays.mask.data = NULL;
    source->arrays.stream_count = 0;
    int32_t status = mlrt_make_view(camera, &source->view);
    if (status != MLRT_OK) return status;
    source->width = source->view.crop_width;
    source->height = source->view.crop_height;
    source->count = source->width * source->height;
    return MLRT_OK;
}

void mlrt_make_ray_source(const struct mlrt_tree *tree, const mlrt_rays *rays, struct mlrt_source *source)
{
    source->kind = MLRT_SOURCE_RAYS;
    source->tree = tree;
    source->arrays.rays_per_origin = rays->rays_per_origin ? rays->rays_per_origin : 1;
    source->arrays.points = resolve_array(&rays->origins, 12);
    source->arrays.directions = resolve_array(&rays->directions, 12);
    source->arrays.t_min = resolve_array(&rays->t_min, 4);
    source->arrays.t_max = resolve_array(&rays->t_max, 4);
    source->arrays.skip = resolve_array(&rays->skip, 8);
    source->arrays.mask = resolve_array(&rays->mask, 4);
    set_extent(source, rays->count, rays->row_length);
}

void mlrt_set_light(const mlrt_light *light, struct mlrt_source *source)
{
    source->kind = light->kind == MLRT_LIGHT_POINT ? MLRT_SOURCE_POINT_LIGHT : MLRT_SOURCE_DIRECTIONAL_LIGHT;
    memcpy(source->light, light->position, sizeof source->light);
}

void mlrt_make_light_source(const struct mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                            struct mlrt_source *source)
{
    mlrt_set_light(light, source);
    source->arrays.directions.data = source->arrays.t_min.data = source->arrays.t_max.data = source->arrays.mask.data =
        NULL;
    source->tree = tree;
    source->arrays.rays_per_origin = 1;
    source->arrays.points = resolve_array(&points->positions, 12);
    source->arrays.skip = resolve_array(&points->skip, 8);
    set_extent(source, points->count, points->row_length);
}

void mlrt_set_masks(const struct mlrt_tree *tree, uint32_t common, struct mlrt_source *source)
{
    if (!tree->masks) source->arrays.mask.data = NULL;
    source->common_mask = tree->masks && !source->arrays.mask.data && common ? common : MLRT_MASK_ALL;
}

/* ---- reading rays ---- */

int mlrt_get_ray(const struct mlrt_source *source, uint32_t i, struct mlrt_ray_segment *ray, uint32_t *skip)
{
    struct mlrt_lone_ray given;
    float room[3];
    *skip = MLRT_NONE;
    if (i >= source->count) return 0;
    mlrt_begin_rays(source, &given);
    mlrt_read_ray(source, i, room, &given);
    *skip = given.skip;
    return mlrt_get_lone_segment(&given, ray);
}

/* ---- packets ---- */

/* The ray of a block's lane. A lane that does not exist has the block's first ray; without lanes, all have ray 0. */
MLRT_INLINE uint32_t ray_of_lane(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                                 uint32_t lane)
{
    const uint32_t first = lanes ? y * source->width + x : 0;
    return first + (lanes >> lane & 1 ? (uint32_t)mlrt_lane_offset(lane, 1, source->width) : 0);
}

void mlrt_fetch_masks(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                      struct mlrt_packet *packet)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane)
        packet->mask[lane] = mlrt_mask_of_ray(source, ray_of_lane(source, x, y, lanes, lane));
}

void mlrt_begin_packet(const struct mlrt_source *source, struct mlrt_packet *packet)
{
    const struct mlrt_ray_arrays *arrays = &source->arrays;
    packet->has.apex = source->kind == MLRT_SOURCE_POINT_LIGHT;
    packet->has.limits = arrays->t_min.data || arrays->t_max.data;
    packet->has.skip = arrays->skip.data != NULL;
    packet->has.masks = arrays->mask.data != NULL;
    if (packet->has.apex) memcpy(packet->apex, source->light, sizeof packet->apex);
}

void mlrt_fetch_packet(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                       struct mlrt_packet *packet)
{
    struct mlrt_lone_ray ray;
    mlrt_begin_packet(source, packet);
    mlrt_begin_rays(source, &ray);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        float room[3];
        mlrt_read_ray(source, ray_of_lane(source, x, y, lanes, lane), room, &ray);
        for (int k = 0; k < 3; ++k) {
            packet->origin[k][lane] = ray.given.origin[k];
            packet->direction[k][lane] = ray.given.direction[k];
        }
        packet->t_min[lane] = ray.t_min;
        packet->t_max[lane] = ray.t_max;
        if (packet->has.masks) packet->mask[lane] = ray.mask;
        if (packet->has.skip) packet->skip[lane] = ray.skip;
    }
}

uint32_t mlrt_lanes_of_list(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes)
{
    uint32_t inside = 0;
    for (uint32_t row = 0; row < 4; ++row) {
        const uint64_t first = (y + (uint64_t)row) * source->width + x;
        if (first >= source->count) break;
        const uint64_t left = source->count - first;
        inside |= mlrt_block_lanes(left < 4 ? (uint32_t)left : 4, row + 1) & ~mlrt_block_lanes(4, row);
    }
    return lanes & inside;
}

/* ---- prefetching ---- */

void mlrt_begin_source_rows(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_rows_ahead *rows)
{
    rows->height = rows->count = 0;
    if (x >= source->width || y >= source->height) return;
    rows->height = source->height - y;
    const uint32_t width = source->width - x < 16 ? source->width - x : 16;
    const size_t first = (size_t)y * source->width + x;
    for (uint32_t i = 0; i < source->arrays.stream_count; ++i) {
        const mlrt_const_array *array = &source->arrays.streams[i];
        const size_t stride = array->stride;
        mlrt_add_rows_ahead((const char *)array->data + first * stride, width * stride, source->width * stride, 0,
                            rows);
    }
}
