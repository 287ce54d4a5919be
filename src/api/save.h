/* SPDX-License-Identifier: MIT */
/* Functions for trees that are built and trees that are loaded. */
#ifndef MLRT_API_SAVE_H
#define MLRT_API_SAVE_H

#include "scene/tree.h"

/* Returns an empty tree, allocated from `memory`, which it keeps; NULL if out of memory (tree.c). */
struct mlrt_tree *mlrt_allocate_tree(const struct mlrt_structure *structure, const struct mlrt_memory *memory);

/* If the tree's arrays are borrowed, drops them, so that only the tree itself is left to be freed (save.c). */
void mlrt_return_arrays(struct mlrt_tree *tree);

#endif
