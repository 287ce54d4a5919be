/* SPDX-License-Identifier: MIT */
/* interior.h - a view from inside, for scenes that are rooms */
#ifndef INTERIOR_H
#define INTERIOR_H

#include "scene.h"

/*
 * If most points within the scene's box are shut in by surfaces that show them their fronts, the scene is an interior,
 * and the view moves to a place inside from which much of it is seen, with the light above. Otherwise, and if there is
 * no memory for it, the view stays. Only views of the interior's own are worth the tree that this builds.
 */
void look_from_inside(struct scene *scene);

#endif
