/* SPDX-License-Identifier: MIT */
/*
 * import.h - mesh files through assimp (PLY, OBJ, STL, glTF and some forty more)
 *
 * All meshes of the file become one, in the order of the file's scene graph and in world space. Polygons become
 * triangles; points and lines are left out. Nothing is cleaned: triangles keep their order, degenerate ones included,
 * and vertices of binary files keep their bits. (assimp rounds about one in 5,000 numbers of a text file to a neighbour
 * of the nearest float; transforms of nodes round, too.)
 */
#ifndef IMPORT_H
#define IMPORT_H

#include "scene.h"

/* Fills vertices and indices of an empty scene. Returns 0, or 1 after a message on stderr. */
int import_mesh(const char *path, struct scene *scene);

#endif
