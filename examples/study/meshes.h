/* SPDX-License-Identifier: MIT */
/*
 * meshes.h - small meshes of triangles that share their corners, to find out where a method starts to fail
 *
 * Each function fills an empty scene and returns 0, or 1 after saying on stderr that there is no memory. Coordinates
 * are computed in double and rounded to float once. All meshes are turned by the same arbitrary rotation, so that no
 * face is parallel to an axis by design.
 */
#ifndef MESHES_H
#define MESHES_H

#include "common/scene.h"

/* 20,480 triangles: an icosahedron whose triangles were cut into four, five times. */
enum { SPHERE_LEVEL = 5 };

/* A point p becomes scale * p + shift. */
struct placement {
    double scale;
    double shift;
};

/* A closed sphere of radius 1 around 0: 20 * 4^level triangles. `placement` NULL = as it is. */
int make_sphere(uint32_t level, const struct placement *placement, struct scene *scene);

/*
 * A flat sheet through 0: columns x rows rectangles of `width` x `height`, each two triangles. *normal receives its
 * direction, *axes the directions of columns and rows, all of length 1.
 */
int make_sheet(uint32_t columns, uint32_t rows, double width, double height, struct scene *scene, double normal[3],
               double axes[2][3]);

#endif
