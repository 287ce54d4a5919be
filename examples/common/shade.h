/* SPDX-License-Identifier: MIT */
/*
 * shade.h - what examples do with a tile of hits while it is in the cache: colours, and hard shadows of a point light
 *
 * Without shadows the shade of a hit is the dot product of the ray's direction with the triangle's normal. With shadows
 * the hits become points moved off their surface, one call asks which of the tile's points the light does not reach,
 * and lit points get its light on top. Triangles have the scene's materials, or else a tint from warm to cool by where
 * they face.
 */
#ifndef SHADE_H
#define SHADE_H

#include "scene.h"

#include <mlrt.h>

enum { MAXIMUM_WORKERS = 1024 }; /* as many as a pool can have */

struct tile_buffers;

/* Where shadow rays end, one for each pixel, and the triangle that each passes. */
struct shadow_points {
    float (*positions)[3];
    uint32_t (*skip)[2];
};

struct shading {
    const struct scene *scene;
    const mlrt_tree *tree;
    const mlrt_camera *camera;
    const struct view *view;           /* its light is used */
    mlrt_trace_options shadow_options; /* without a pool */
    int shadows;                       /* 1 = ask for them */
    int counting;                      /* 1 = count them */
    uint8_t *rgb;                      /* where the picture goes, 3 bytes a pixel; NULL = no colours */
    uint8_t *rgba;                     /* where the picture of shade_tile_simply goes, 4 bytes a pixel */
    uint8_t *occluded;  /* where the answers for the light go, a byte a pixel, 0 for a miss; NULL = nowhere */
    uint8_t tone[4096]; /* from linear to sRGB; prepared by start_shading */
    struct tile_buffers *buffers[MAXIMUM_WORKERS];
};

/* Prepares a zeroed struct whose first group of fields is set. */
void start_shading(struct shading *shading);

/* Frees what workers have allocated; the numbers go with it. */
void end_shading(struct shading *shading);

/* What `outputs` must be in the trace options: nothing that is not needed. */
uint32_t shading_outputs(const struct shading *shading);

/* The tile callback; `user` is the struct shading. */
int32_t shade_tile(void *user, const mlrt_tile *tile);

/*
 * A tile callback that does next to nothing, for measuring: a grey by the angle between the ray and the triangle, into
 * `rgba`. Needs MLRT_OUTPUT_IDS, and `scene`, `camera` and `rgba` of the struct shading that `user` is.
 */
int32_t shade_tile_simply(void *user, const mlrt_tile *tile);

/*
 * Fills in the shadow points of a tile of hits, which has ids, u, v and facing: just off the surface, on the side that
 * the ray came from. A miss gets a point that is nowhere, which is never occluded. Returns the number of the others.
 */
size_t place_shadow_points(const mlrt_tree *tree, const mlrt_tile *hits, const struct shadow_points *points);

/* Asks which points of a tile of width x height a point light does not reach. Returns the library's status. */
int32_t trace_shadow_points(const mlrt_tree *tree, const struct shadow_points *points, uint32_t width, uint32_t height,
                            const double light_position[3], const mlrt_trace_options *options, uint8_t *occluded);

/* The shadow rays since the start or the last reset: their number, and the counters added up if they were counted. */
uint64_t shadow_ray_count(const struct shading *shading);
void add_shadow_counters(const struct shading *shading, mlrt_counters *sum);
void reset_shadow_counters(struct shading *shading);

#endif
