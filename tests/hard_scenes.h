/* SPDX-License-Identifier: MIT */
/*
 * Small scenes (2,000 triangles or fewer) on which ray tracers have failed. Each is a generator with a seed, and names
 * the hard cases it is about; what a case needs of the rays comes from hostile_rays.h. The cases, and their answers:
 *
 *    1 an edge shared by two triangles, both windings: never a hole
 *    2 the vertex of a fan of 3 to 64 triangles: never a hole
 *    3 a vertex of an open border: hit if the closed triangle has it
 *    4 needles of aspect 1e6 that share edges: no hole
 *    5 grazing rays at skinny triangles: t within the triangle's
 *    6 short segments far before a triangle: miss
 *    7 rays in a triangle's plane: miss
 *    8 origins on, or a float before or behind a triangle
 *    9 t exactly t_min: miss; exactly t_max: hit
 *   10 coincident triangles: the first of the input
 *   11 planes one float apart: the nearer one
 *   12 triangles without area: never hit
 *   13 vertices that are NaN or infinite: never hit
 *   14 coordinates of any size; small features far out
 *   15 denormals: what they are
 *   16 directions of any length
 *   17 rays that are not valid: miss, neighbours unharmed
 *   18 t_min >= t_max, t_max infinite or below 0
 *   19 edge functions that are 0 in float only: decided exactly
 *   20 closed meshes: no leak, from inside
 *   21 directions of +0 and -0: the same
 *   22 rays in split planes: both sides
 *   23 rays along edges of cells and of the box
 *   24 an origin in a split plane
 *   25 a triangle in a split plane: from either side
 *   26 a cell without thickness: still visited
 *   27 a scene flat in one axis
 *   28 no triangle, one, many identical ones
 *   29 many triangles through a point; one huge one
 *   30 planes at neighbouring floats
 *   31 parts of triangles that are a point or a line
 *   32 origins in cells, in solids, far away
 *   33 a hit outside the cell it is found in
 *   34 the deepest trees
 *   35 beams whose corner rays see nothing
 *   36 tiles around a direction with zeros
 *   37 triangles smaller than a pixel
 *   38 triangles that nearly cover a tile
 *   39 covering triangles that intersect
 *   40 covering triangles that leave the cell
 *   41 an apex in a plane, at a vertex
 *   42 extreme zoom, odd picture sizes
 *   43 lights on, in and at surfaces
 *   44 samples anywhere in a pixel
 *   45 any order, grouping, number of threads
 *   46 more subtrees than a list holds
 */
#ifndef TESTS_HARD_SCENES_H
#define TESTS_HARD_SCENES_H

#include "support.h"

struct hard_scene {
    const char *name;
    const char *cases;
    void (*make)(struct soup *soup, struct random *random);
    float scale; /* of all coordinates, afterwards; 0 = 1 */
    float shift; /* then added to x, y and, negative, to z */
    int deep;    /* 1 = to be built as deep as can be */
};

size_t hard_scene_count(void);
const struct hard_scene *hard_scene_at(size_t index);

/* The seed of a scene is its position plus one. */
struct fixture make_hard_scene(size_t index);

#endif
