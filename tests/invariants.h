/* SPDX-License-Identifier: MIT */
/*
 * All invariants of trees, for points of each triangle that are exact in double: its vertices, and where possible
 * points of its edges and inside. What loading checks (bvh/check.c, mlrta/check.c) is part of it.
 */
#ifndef INVARIANTS_H
#define INVARIANTS_H

#include "scene/tree.h"

/* Check B1 to B5 (bvh/node.h), or I1 to I5 (mlrta/kdtree.h). Return NULL, or a static string with the first error. */
const char *check_bvh(const struct mlrt_tree *tree);
const char *check_kdtree(const struct mlrt_tree *tree);

#endif
