/* SPDX-License-Identifier: MIT */
/* draw.h - the engine's tile callback: adds bodies, shadows and colours while the tile is in the cache */
#ifndef ENGINE_DRAW_H
#define ENGINE_DRAW_H

#include "engine/world.h"

enum { TILE_SIZE = 64 };

struct pixels;

/* The data of one worker: no other thread uses it, so none waits. */
struct draw_worker {
    struct pixels *pixels;
    struct stack stack; // memory for calls made from within the callback
    mlrt_host host;     // whose functions take it
};

struct drawing {
    const struct world *world;
    const mlrt_camera *camera;
    uint8_t *rgb; // the picture
    struct draw_worker *workers;
    uint32_t worker_count;
    struct heap *heap;
};

/* Allocates workers. Returns a status. */
int32_t drawing_begin(struct drawing *drawing);
void drawing_end(struct drawing *drawing);

/* What the callback wants to be given. */
enum { TILE_OUTPUTS = MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_IDS | MLRT_OUTPUT_FACING };

/* The callback; `drawing` is the struct. */
int32_t draw_tile(void *drawing, const mlrt_tile *tile);

/* The nearest body that a ray from the camera through a point of the picture hits, BODY_COUNT if the room is nearer. */
uint32_t pick(const struct world *world, const mlrt_camera *camera, float x, float y);

#endif
