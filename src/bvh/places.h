/* SPDX-License-Identifier: MIT */
/*
 * Triangles by number in a hierarchy of boxes: leaves have their corners, so the tree keeps no other copy, but for each
 * triangle a place in a leaf. Triangles that no leaf has, or none as they were given, have places in quads of their
 * own behind those of leaves: those that are left out, and odd ones (unit.h).
 *
 *   P1. If tree->bvh.places is not NULL, the place of triangle i is in the first bvh.quad_count quads, and bvh.numbers
 *       has i there. The place is in a leaf, and the triangle is neither odd nor left
 *       out, or it is in one of the quads behind leaves, where corners are as they were given.
 *
 * A hierarchy of MLRT_PLACE_QUADS quads and more keeps the array tree->triangles, and has no places.
 */
#ifndef MLRT_BVH_PLACES_H
#define MLRT_BVH_PLACES_H

#include "scene/tree.h"

/* How many quads have to be behind those of leaves. tree->info must have the counts of triangles left out. */
uint32_t mlrt_count_given_quads(const struct mlrt_tree *tree);

/*
 * Writes the quads behind leaves, and the places of their triangles: of those that have MLRT_NONE, which is no place.
 * The others have theirs from leaves.
 */
void mlrt_write_given(struct mlrt_tree *tree);

/* If a tree has places, frees its array of triangles in order, so that they are read by their places. */
void mlrt_drop_order(struct mlrt_tree *tree);

/* Lets tree->by_number read triangles by their places. */
void mlrt_read_by_places(struct mlrt_tree *tree);

/*
 * Checks that places are within the quads: then mlrt_triangle_at may be called. Returns NULL or the error, a static
 * string.
 */
const char *mlrt_check_places(const struct mlrt_tree *tree);

#endif
