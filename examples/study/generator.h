/* SPDX-License-Identifier: MIT */
/*
 * generator.h - the rays that every method traces
 *
 *     camera       the picture of the scene's view, as square as the number of rays allows
 *     random       in random directions, each as likely
 *     surface      towards a point inside a triangle
 *     edge         towards a point on an edge
 *     vertex       towards a vertex
 *     axis         parallel to an axis; the line of every other ray goes exactly through a vertex
 *     split_plane  within a split plane of the kd-tree: one coordinate of all points of a ray is the plane's
 *
 * Triangles, edges and vertices are drawn at random, each as likely. Origins of all but camera are drawn from the
 * middle half of the scene's bounding box (half of it along each axis), so rays in `sphere` start inside and must hit.
 * A target is rounded to float first, and the direction is the difference, rounded to float: like a user's rays, these
 * do not meet their target exactly. Directions have the length of that difference, or 1 without a target.
 */
#ifndef GENERATOR_H
#define GENERATOR_H

#include "subject.h"

struct ray_set {
    int is_picture; // 1 = the rays are those of `camera`, row by row
    mlrt_camera camera;
    size_t count;
    uint32_t row_length; // pixels in a row of a picture; 0 = a plain list
    float (*origins)[3];
    float (*directions)[3];
};

enum generator {
    GENERATE_CAMERA,
    GENERATE_RANDOM,
    GENERATE_SURFACE,
    GENERATE_EDGE,
    GENERATE_VERTEX,
    GENERATE_AXIS,
    GENERATE_SPLIT_PLANE,
    GENERATOR_COUNT
};

const char *generator_name(enum generator generator);

/*
 * Fills an empty set with about `count` rays, always the same ones. Free it with free_rays. Returns 0, or 1 after a
 * message on stderr.
 */
int generate_rays(enum generator generator, const struct subject *subject, size_t count, struct ray_set *rays);

/* An empty set becomes one of `count` rays that are not set yet. Returns as generate_rays does. */
int allocate_rays(size_t count, struct ray_set *rays);

/* The greatest magnitude of a component of an origin or direction. */
float largest_component(const struct ray_set *rays);

void free_rays(struct ray_set *rays);

#endif
