/* SPDX-License-Identifier: MIT */
/*
 * Rays that hurt, for any scene of any scale: each kind takes its coordinates from the scene's own vertices and box.
 * The same seed gives the same rays.
 */
#ifndef TESTS_HOSTILE_RAYS_H
#define TESTS_HOSTILE_RAYS_H

#include "support.h"

/* ---- numbers and places ------------------------------------------------------------------------------------------ */

float round_finite(double value);          /* to the nearest finite float */
double draw_unit(struct random *random);   /* [0, 1) */
double draw_signed(struct random *random); /* [-1, 1) */
float signed_zero(struct random *random);
void draw_direction(struct random *random, float direction[3]); /* in the cube [-1, 1)^3 */

/* A triangle whose coordinates are finite, if a few attempts find one; NULL in a scene without. */
const struct reference_triangle *draw_triangle(struct random *random, const struct fixture *fixture);

/* A vertex of the scene; 0 in a scene without triangles, as for the next two. */
void draw_vertex(struct random *random, const struct fixture *fixture, float vertex[3]);

/* A vertex, a point on an edge as far as floats go, or an inner point. */
void draw_point_of_triangle(struct random *random, const struct reference_triangle *triangle, float point[3]);
void draw_target(struct random *random, const struct fixture *fixture, float target[3]);

/* Half of them in the scene's box and around it, half at distances from a vertex like some triangle's size, or more. */
void draw_origin(struct random *random, const struct fixture *fixture, float origin[3]);

/* ---- kinds of rays ----------------------------------------------------------------------------------------------- */

/* A kind of ray, and which of the hard cases (numbers as in hard_scenes.h) it brings to every scene. */
struct hostile_kind {
    const char *name;
    const char *cases;
    uint32_t weight; /* how often it is drawn, relative to the others */
};

size_t hostile_kind_count(void);
const struct hostile_kind *hostile_kind_at(size_t kind);

/* A kind, by weight. */
size_t draw_hostile_kind(struct random *random);

/* Adds `count` rays (or up to 255 more, to fill a bundle) of one kind. */
void add_hostile_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t kind,
                      size_t count);

/* ---- cameras and lights ------------------------------------------------------------------------------------------ */

/* A pinhole or a parallel camera of `size` squared pixels near the scene, one of whose pixels goes through a vertex. */
mlrt_camera draw_hostile_camera(struct random *random, const struct fixture *fixture, uint32_t size);

/* A light, and `count` points: vertices, points of triangles, offset points with their `skip`, points at the light. */
mlrt_light draw_hostile_light(struct random *random, const struct fixture *fixture);
void draw_hostile_points(struct random *random, const struct fixture *fixture, const mlrt_light *light, size_t count,
                         float *points, uint32_t *skip);

#endif
