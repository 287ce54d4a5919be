/* SPDX-License-Identifier: MIT */
/*
 * world.h - the scene of the engine: a static room, and bodies that move, each with a tree in coordinates of its own
 *
 * A rigid body keeps its tree when it moves: rays are transformed into its coordinates. So two bodies can share a tree.
 * The body that changes its shape gets a new tree in every frame.
 */
#ifndef ENGINE_WORLD_H
#define ENGINE_WORLD_H

#include "common/scene.h"
#include "engine/heap.h"

#include <mlrt.h>

/* Bits of masks: who sees a mesh. */
enum { SEEN_BY_CAMERA = 1, SEEN_BY_LIGHT = 2, SEEN_BY_MOUSE = 4, SEEN_BY_ALL = 7 };

enum { MESH_ROOM, MESH_BULB };                                       // ids in the room's tree
enum { BODY_BLOB, BODY_RING, BODY_RING_2, BODY_MARKER, BODY_COUNT }; // the marker hovers over what the mouse points at

struct shape {
    struct scene mesh; // vertices and triangles
    float *normals;    // 3 per vertex
    mlrt_tree *tree;
};

struct body {
    const char *name;
    const struct shape *shape;
    float rotation[3][3]; // from the body's coordinates to the world's
    float position[3];
    float radius; // of a ball around `position` that the body is in
    float colour[3];
};

struct world {
    mlrt_host host; // of all trees
    struct scene room, bulb;
    mlrt_tree *tree;
    struct shape shapes[3]; // blob, ring, marker
    struct body bodies[BODY_COUNT];
};

/* Makes everything but the room's tree. Both return a status of the library. */
int32_t world_begin(struct world *world, const mlrt_host *host);
void world_end(struct world *world);

/* Moves rigid bodies to where they are at a time, in seconds, the marker over `picked` (BODY_COUNT = nothing). */
void world_move(struct world *world, double time, uint32_t picked);

/* Gives the blob the shape that it has at a time, and a tree for it. May run beside world_move. */
int32_t world_deform(struct world *world, double time);

/* Points and directions (`is_point` = 0) from the world's coordinates to a body's, and back. */
void to_body(const struct body *body, const float from[3], int is_point, float to[3]);
void to_world(const struct body *body, const float from[3], int is_point, float to[3]);

#endif
