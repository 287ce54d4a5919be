/* SPDX-License-Identifier: MIT */
/*
 * scene.h - the scenes of the examples: one indexed triangle mesh, its colours, a view and a light
 *
 * A scene is procedural or comes from a file. Procedural ones are the same, bit for bit, on every machine:
 *
 *     room        a furnished room: 800 triangles
 *     office      a conference room: 280 thousand
 *     building    five storeys of corridors and furnished rooms: 2 million, of which a view sees less than 1 %
 *     doubled     a kitchen whose large surfaces are there twice, at most 3 floats apart: 19 thousand
 *     scan        one closed, densely triangulated surface: 1 million, or about N of them with scan:N
 */
#ifndef SCENE_H
#define SCENE_H

#include <stddef.h>
#include <stdint.h>

/* A pinhole view and a point light. */
struct view {
    double eye[3];
    double look[3]; /* the point in the middle of the picture */
    double up[3];
    double vfov; /* degrees, from the lower edge to the upper */
    double light[3];
};

/* What a triangle looks like. Colours are linear, 0..1. */
struct material {
    float colour[3];
    float glow; /* light that it gives off by itself: 0 = none */
};

enum { MATERIAL_COUNT = 32 };

struct scene {
    float *vertices;       /* 3 per vertex */
    uint32_t *indices;     /* 3 per triangle */
    uint8_t *material_ids; /* 1 per triangle, into `materials`; NULL = no colours known */
    size_t vertex_count;
    size_t triangle_count;
    struct material materials[MATERIAL_COUNT];
    struct view view;   /* a good one; of a mesh file the whole from outside, before look_from_inside */
    int is_imported;    /* 1 = from a mesh file, which has no view of its own */
    double light_range; /* the distance at which the light has half its strength; 0 = the same everywhere */
};

/*
 * Loads a procedural scene by its name, or a mesh file. Returns 0, or 1 after a message on stderr; *scene is
 * empty then. Free it with free_scene either way.
 */
int load_scene(const char *name_or_path, struct scene *scene);

void free_scene(struct scene *scene);

/* The corners of the smallest box around the finite vertices that triangles use. All 0 if there is none. */
void scene_bounds(const struct scene *scene, float minimum[3], float maximum[3]);

#endif
