/* SPDX-License-Identifier: MIT */
/*
 * shade.h - colours for a tile of hits while it is in the cache, with hard shadows of a point light
 *
 * Without shadows the shade of a hit is the dot product of the ray's direction with the triangle's normal. With
 * shadows, the light is added to the hits that it reaches, which the tile's `occluded` tells. Triangles have the
 * scene's materials, or else a tint from warm to cool by the direction that they face.
 */
#ifndef SHADE_H
#define SHADE_H

#include "scene.h"

#include <mlrt.h>

enum { MAXIMUM_WORKERS = 1024 }; /* as many as a pool can have */

struct shading {
    const struct scene *scene;
    const mlrt_camera *camera;
    const struct view *view; /* its light is used */
    int shadows;             /* 1 = the light is the only one in the trace options */
    uint8_t *rgb;            /* where the picture goes, 3 bytes a pixel */
    uint8_t *rgba;           /* where the picture of shade_tile_simply goes, 4 bytes a pixel */
    uint8_t tone[4096];      /* from linear to sRGB; prepared by start_shading */
};

/* Prepares a zeroed struct whose first group of fields is set. */
void start_shading(struct shading *shading);

/* What `outputs` must be in the trace options: nothing that is not needed. */
uint32_t shading_outputs(const struct shading *shading);

/* The tile callback; `user` is the struct shading. */
int32_t shade_tile(void *user, const mlrt_tile *tile);

/*
 * A tile callback that does next to nothing, for measuring: a grey by the angle between the ray and the triangle, into
 * `rgba`. Needs MLRT_OUTPUT_IDS, and `scene`, `camera` and `rgba` of the struct shading that `user` is.
 */
int32_t shade_tile_simply(void *user, const mlrt_tile *tile);

#endif
