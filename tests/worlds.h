/* SPDX-License-Identifier: MIT */
/*
 * Scenes without end, of up to some hundred triangles each, on which ray tracers could fail. A world is a number: it
 * chooses one of some twenty scenes, and the seed from which all else is drawn. After the first two worlds of each scene
 * most are twisted: parts of other scenes join them, triangles become too large or too small for float, lie across an
 * axis, or are there several times, a few floats aside; axes have scales of their own; triangles change their order.
 *
 * What a fixed list of scenes has not, these have: any two ways to be hard, at once.
 */
#ifndef TESTS_WORLDS_H
#define TESTS_WORLDS_H

#include "support.h"

enum { WORLD_MESH_LIMIT = 4 };

/* A scene, in one mesh or in several with masks. */
struct world {
    char name[100];
    struct soup soup;
    mlrt_mesh meshes[WORLD_MESH_LIMIT];
    size_t mesh_count;
    struct fixture fixture; /* of all triangles: its reference knows nothing of masks; its seed is the number */
    struct reference_scene *visible[1 << WORLD_MESH_LIMIT]; /* of the meshes in a set; made when they are asked for */
};

/* Worlds 0 to this less one have one scene each. */
size_t world_scene_count(void);

/* Fills `world`, which must be 0. The kd-tree is built only if it is asked for. */
void make_world(uint64_t number, int with_kdtree, struct world *world);
void free_world(struct world *world);

/* What rays with this mask (0 = all bits) see. */
struct reference_scene *visible_part(struct world *world, uint32_t mask);

#endif
