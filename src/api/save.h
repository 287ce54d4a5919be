/* SPDX-License-Identifier: MIT */
/*
 * What trees that are built and trees that are loaded share.
 */
#ifndef MLRT_API_SAVE_H
#define MLRT_API_SAVE_H

#include "scene/tree.h"

/* A tree without anything in it, allocated from this memory, which it keeps. NULL if there is none (tree.c). */
struct mlrt_tree *mlrt_allocate_tree(const struct mlrt_memory *memory);

/* If the tree's arrays are borrowed, gives them back: there is nothing left to free but the tree itself. */
void mlrt_return_arrays(struct mlrt_tree *tree);

#endif
