/* SPDX-License-Identifier: MIT */
/*
 * Sources of rays: a camera, the caller's arrays, or a light and points. To the kernels each is a picture: a rectangle
 * of rays, cut into tiles and blocks.
 *
 * A plain list is a picture four rays wide. So 16 neighbours in the list are a block, and 4 n neighbours are a tile of
 * side n.
 */
#ifndef MLRT_RAYS_SOURCE_H
#define MLRT_RAYS_SOURCE_H

#include <math.h>

#include "base/rows_ahead.h"
#include "exact/predicate.h"
#include "rays/camera.h"
#include "rays/lone_ray.h"
#include "rays/packet.h"
#include "scene/tree.h"
#include "scene/triangle_numbers.h"

enum mlrt_source_kind {
    MLRT_SOURCE_CAMERA,
    MLRT_SOURCE_RAYS,
    MLRT_SOURCE_POINT_LIGHT,      /* origins: the light; directions: from it to the points */
    MLRT_SOURCE_DIRECTIONAL_LIGHT /* origins: the points; directions: the light's */
};

/* The arrays of a source, with resolved strides: 0 where one element serves all rays. A camera has none. */
struct mlrt_ray_arrays {
    mlrt_const_array points; /* rays: the origins; lights: the points */
    mlrt_const_array directions;
    mlrt_const_array t_min;
    mlrt_const_array t_max;
    mlrt_const_array skip;
    mlrt_const_array mask;
    mlrt_const_array streams[5]; /* the arrays above that are prefetched */
    uint32_t stream_count;
    uint32_t rays_per_origin; /* ray i has element i / rays_per_origin of points, t_min and skip; over 1: a list */
};

struct mlrt_source {
    enum mlrt_source_kind kind;
    uint32_t width;
    uint32_t height;
    uint32_t count;   /* number of rays; the last row may be short */
    mlrt_camera view; /* camera (camera.h) */
    float light[3];   /* point light: its position; directional light: the direction to it */
    struct mlrt_ray_arrays arrays;
    const struct mlrt_tree *tree; /* `skip` has ids of its meshes */
    uint32_t common_mask;         /* the mask of all rays, if `mask` has no data. Set by mlrt_set_masks */
};

/* Resolves masks; `common` is that of the options. If the triangles of the tree have no masks, the rays get none. */
void mlrt_set_masks(const struct mlrt_tree *tree, uint32_t common, struct mlrt_source *source);

/* Is there a ray that does not see all triangles? */
static inline int mlrt_has_masks(const struct mlrt_source *source)
{
    return source->arrays.mask.data || source->common_mask != MLRT_MASK_ALL;
}

/* Make a source of structs that were checked, and resolve strides. The camera is checked here: returns a status. */
int32_t mlrt_make_view_source(const mlrt_camera *camera, struct mlrt_source *source);
void mlrt_make_ray_source(const struct mlrt_tree *tree, const mlrt_rays *rays, struct mlrt_source *source);
void mlrt_make_light_source(const struct mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                            struct mlrt_source *source);

/* Sets kind and light of a source. */
void mlrt_set_light(const mlrt_light *light, struct mlrt_source *source);

/*
 * Cuts the rays of arrays into rows of this length. If it is 0, or rays_per_origin is not 1, or the rays fit into one
 * packet, they are a list.
 */
void mlrt_set_rows(uint32_t row_length, struct mlrt_source *source);

/*
 * Reads ray i of arrays. Returns 0 if it can hit nothing, or does not exist. *skip receives the number of the triangle
 * that it passes through, or MLRT_NONE.
 */
int mlrt_get_ray(const struct mlrt_source *source, uint32_t i, struct mlrt_ray_segment *ray, uint32_t *skip);

/* Element i of an array with a resolved stride. */
MLRT_INLINE const float *mlrt_element(const mlrt_const_array *array, uint32_t i)
{
    return (const float *)(const void *)((const unsigned char *)array->data + (size_t)i * array->stride);
}

/* The element of ray i in an array with one for each `group` rays. That is nearly always 1, and needs no division. */
MLRT_INLINE uint32_t mlrt_element_of_ray(uint32_t i, uint32_t group)
{
    return MLRT_LIKELY(group == 1) ? i : i / group;
}

MLRT_INLINE uint32_t mlrt_mask_of_ray(const struct mlrt_source *source, uint32_t i)
{
    if (!source->arrays.mask.data) return source->common_mask;
    const uint32_t mask = *(const uint32_t *)(const void *)mlrt_element(&source->arrays.mask, i);
    return mask ? mask : MLRT_MASK_ALL;
}

/* Sets the fields of *ray that mlrt_read_ray leaves alone where a source has no array for them. */
MLRT_INLINE void mlrt_begin_rays(const struct mlrt_source *source, struct mlrt_lone_ray *ray)
{
    ray->given.origin = ray->given.direction = source->light;
    ray->t_min = 0;
    ray->t_max = source->kind == MLRT_SOURCE_POINT_LIGHT ? 1 : INFINITY;
    ray->mask = source->common_mask;
    ray->skip = MLRT_NONE;
}

/*
 * Reads ray i of arrays, as it was given: vectors, limits, mask and skip of *ray, after mlrt_begin_rays. `room` holds a
 * vector that is in no array.
 */
MLRT_INLINE void mlrt_read_ray(const struct mlrt_source *source, uint32_t i, float room[3], struct mlrt_lone_ray *ray)
{
    const uint32_t origin = mlrt_element_of_ray(i, source->arrays.rays_per_origin);
    const float *point = mlrt_element(&source->arrays.points, origin);
    if (MLRT_LIKELY(source->kind == MLRT_SOURCE_RAYS)) {
        ray->given.origin = point;
        ray->given.direction = mlrt_element(&source->arrays.directions, i);
        if (source->arrays.t_min.data) ray->t_min = *mlrt_element(&source->arrays.t_min, origin);
        if (source->arrays.t_max.data) ray->t_max = *mlrt_element(&source->arrays.t_max, i);
    } else if (source->kind == MLRT_SOURCE_POINT_LIGHT) {
        for (int k = 0; k < 3; ++k) room[k] = point[k] - source->light[k];
        ray->given.direction = room;
    } else {
        ray->given.origin = point;
    }
    if (source->arrays.mask.data) ray->mask = mlrt_mask_of_ray(source, i);
    if (!source->arrays.skip.data) return;
    const uint32_t *pair = (const uint32_t *)(const void *)mlrt_element(&source->arrays.skip, origin);
    ray->skip = pair[0] != MLRT_NONE ? mlrt_triangle_number(source->tree, pair[0], pair[1]) : MLRT_NONE;
}

/* 1 if float arithmetic carries the vector, or the ray, without overflow or loss (packet.h). */
static inline int mlrt_are_float_safe(const float vector[3])
{
    return mlrt_is_float_safe(vector[0]) && mlrt_is_float_safe(vector[1]) && mlrt_is_float_safe(vector[2]);
}

static inline int mlrt_is_safe_ray(const struct mlrt_ray_segment *ray)
{
    return mlrt_are_float_safe(ray->origin) && mlrt_are_float_safe(ray->direction);
}

/* Is the source a list, or rows as short? Its tiles are one packet wide then. */
static inline int mlrt_is_list(const struct mlrt_source *source)
{
    return source->kind != MLRT_SOURCE_CAMERA && source->width <= 4;
}

static inline int mlrt_is_light(const struct mlrt_source *source)
{
    return source->kind == MLRT_SOURCE_POINT_LIGHT || source->kind == MLRT_SOURCE_DIRECTIONAL_LIGHT;
}

static inline int mlrt_is_pinhole(const struct mlrt_source *source)
{
    return source->kind == MLRT_SOURCE_CAMERA && !mlrt_is_parallel(&source->view);
}

/* Sets what all rays of a packet of arrays have: `has`, and the apex of a point light. */
void mlrt_begin_packet(const struct mlrt_source *source, struct mlrt_packet *packet);

/*
 * Reads the numbers of a block of at most 4x4 rays of arrays at (x, y), as they are given, one ray after the other:
 * direction, origin, t_min, t_max, mask and skip of a packet. `lanes` are those that exist, the first among
 * them, or none; other lanes are not specified. Begins the packet, and checks nothing: check_packet.h does.
 */
void mlrt_fetch_packet(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                       struct mlrt_packet *packet);

/* Reads the masks alone, of a source that has an array of them. */
void mlrt_fetch_masks(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                      struct mlrt_packet *packet);

/* Of the lanes of a block at (x, y), those whose rays are not past the end of a list. */
uint32_t mlrt_lanes_of_list(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes);

/*
 * Begins with rows of up to 16 rays, from (x, y) on, of the arrays that have an element for each ray. Without rays at
 * (x, y) there are none.
 */
void mlrt_begin_source_rows(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_rows_ahead *rows);

#endif
