/* SPDX-License-Identifier: MIT */
/*
 * Where rays come from: a camera, the caller's arrays, or a light and points. To the kernels all three are a picture: a
 * rectangle of rays, cut into tiles and blocks, with a beam around each tile.
 *
 * A plain list is a picture four rays wide: so 16 neighbours in the list are a block, and a tile of n x n is 4 n of
 * them.
 */
#ifndef MLRT_RAYS_SOURCE_H
#define MLRT_RAYS_SOURCE_H

#include "exact/predicate.h"
#include "rays/camera.h"
#include "rays/packet.h"
#include "scene/tree.h"

enum mlrt_source_kind {
    MLRT_SOURCE_CAMERA,
    MLRT_SOURCE_RAYS,
    MLRT_SOURCE_POINT_LIGHT,      /* origins: the light; directions: from it to the points */
    MLRT_SOURCE_DIRECTIONAL_LIGHT /* origins: the points; directions: the light's */
};

struct mlrt_source {
    enum mlrt_source_kind kind;
    uint32_t width;
    uint32_t height;
    uint32_t count;        /* of rays; the last row may be short */
    struct mlrt_view view; /* camera */
    float light[3];
    /* Arrays with resolved strides: 0 where one element serves all rays. */
    mlrt_const_array points; /* rays: the origins; lights: the points */
    mlrt_const_array directions;
    mlrt_const_array t_min;
    mlrt_const_array t_max;
    mlrt_const_array skip;
    mlrt_const_array mask;
    mlrt_const_array streams[5]; /* of those above that are brought into the cache ahead of time */
    uint32_t stream_count;
    uint32_t rays_per_origin; /* ray i has element i / rays_per_origin of points, t_min and skip; if not 1, in a list */
    const struct mlrt_tree *tree; /* whose ids `skip` names */
    /* Set by mlrt_set_masks. */
    uint32_t common_mask; /* of all rays, if `mask` has no data */
    int has_masks;        /* packets get masks */
};

/*
 * Resolves masks: `common` is that of the options. Where the tree has none, no ray has; and where there is one for all
 * rays, packets have none if `leaves_are_filtered`: if the kernel hides triangles itself.
 */
void mlrt_set_masks(const struct mlrt_tree *tree, uint32_t common, int leaves_are_filtered, struct mlrt_source *source);

/* Checks arrays (their struct_size is right) and resolves strides. */
int32_t mlrt_make_view_source(const mlrt_camera *camera, struct mlrt_source *source);
int32_t mlrt_make_ray_source(const struct mlrt_tree *tree, const mlrt_rays *rays, struct mlrt_source *source);
int32_t mlrt_make_light_source(const struct mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                               struct mlrt_source *source);

/* Sets kind and light of a source. The struct_size of `light` is right. */
int32_t mlrt_set_light(const mlrt_light *light, struct mlrt_source *source);

/* Gives the arrays of a source rows of this length; 0 makes them a list, and so do several rays from one point. */
void mlrt_set_rows(uint32_t row_length, struct mlrt_source *source);

/* The triangles of a mesh: none if there is no such mesh. */
struct mlrt_mesh_range {
    uint32_t first;
    uint32_t count;
};

struct mlrt_mesh_range mlrt_find_mesh(const struct mlrt_tree *tree, uint32_t mesh_id);

/* Number of triangle `triangle` of the mesh with this id; MLRT_NONE if there is none. */
uint32_t mlrt_triangle_number(const struct mlrt_tree *tree, uint32_t mesh_id, uint32_t triangle);

/* The ray at (x, y): 0 if it can hit nothing. *skip receives the number of the triangle that it passes; may be NULL. */
int mlrt_get_ray(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_ray_segment *ray,
                 uint32_t *skip);

/* Can float arithmetic carry the vector, or the ray (packet.h)? */
int mlrt_are_float_safe(const float vector[3]);

static inline int mlrt_is_safe_ray(const struct mlrt_ray_segment *ray)
{
    return mlrt_are_float_safe(ray->origin) && mlrt_are_float_safe(ray->direction);
}

static inline int mlrt_is_pinhole(const struct mlrt_source *source)
{
    return source->kind == MLRT_SOURCE_CAMERA && !source->view.parallel;
}

/*
 * The numbers of a block of at most 4x4 rays at (x, y), for any kind of source: direction, origin, t_min, t_max,
 * has_limits, has_skip, skip_mesh and skip of a packet, as they are given. A point light's packets have its apex
 * instead of origins. `lanes` are those that exist, the first among them, or none. Nothing is checked
 * (check_packet.h does), and the other lanes hold anything.
 */
void mlrt_fetch_packet(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                       struct mlrt_packet *packet);

/* Of these numbers, has_skip, skip_mesh and skip. */
void mlrt_fetch_skips(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes,
                      struct mlrt_packet *packet);

/* Turns the pairs of mesh and triangle that the rays of a packet pass into triangle numbers. */
void mlrt_number_skips(const struct mlrt_tree *tree, struct mlrt_packet *packet);

/* Gives all rays of a packet the mask that the source has for all. */
void mlrt_set_common_mask(const struct mlrt_source *source, struct mlrt_packet *packet);

/* Of the lanes of a block at (x, y), which may be at the end of a list, those that exist. */
uint32_t mlrt_lanes_of_list(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t lanes);

/* Has up to 16 rays of a row, from (x, y) on, brought into the cache, if they lie in arrays and not in a list. */
void mlrt_prefetch_row(const struct mlrt_source *source, uint32_t x, uint32_t y);

#endif
