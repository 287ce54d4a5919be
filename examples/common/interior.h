/* SPDX-License-Identifier: MIT */
/* interior.h - a view from inside, for scenes that are rooms */
#ifndef INTERIOR_H
#define INTERIOR_H

#include "scene.h"

/*
 * Chooses a view for a scene from a mesh file, if the user gave none; other scenes keep theirs. If most points within
 * the scene's box are shut in by surfaces that show them their fronts, the scene is an interior, and the view moves to
 * a place inside from which much of it is seen, with the light above. Otherwise, and without memory for the tree that
 * tells, the view stays.
 */
void look_from_inside(struct scene *scene);

#endif
