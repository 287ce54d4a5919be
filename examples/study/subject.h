/* SPDX-License-Identifier: MIT */
/*
 * subject.h - a subject of the study: a mesh, the library's trees over it, and the oracle that has the right answers
 *
 * Every method gets the same float coordinates: a mesh is moved, scaled or turned, and rounded to float, before the
 * trees, the oracle and the methods get it.
 */
#ifndef SUBJECT_H
#define SUBJECT_H

#include "common/scene.h"

#include <mlrt.h>

enum { SUBJECT_NAME_SIZE = 64 };

struct subject {
    char name[SUBJECT_NAME_SIZE];
    struct scene scene;
    mlrt_tree *boxes, *kdtree;
    struct reference_scene *oracle; // created when it is first asked: see oracle.h
};

/*
 * Loads a scene: one of the procedural ones, `sphere` (see meshes.h), or a mesh file, with its view from the file
 * `views`, as read_view takes it (without SCENE/VIEW: view1 of the scene named like the mesh file). `word` ends at a
 * comma or at its 0. Builds the trees. Returns 0, or 1 after a message on stderr.
 */
int load_subject(const char *word, const char *views, struct subject *subject);

/* Builds the trees of a subject whose name and scene are set. Returns as load_subject does. */
int complete_subject(struct subject *subject);

/* The one that a method (MLRT_METHOD_*) goes through: the kd-tree, but for `tile`. */
const mlrt_tree *subject_tree(const struct subject *subject, int32_t method);

void free_subject(struct subject *subject);

#endif
