/* SPDX-License-Identifier: MIT */
/* A cell of the kd-tree while it is built: whether and where it is cut in two, and its subtree. */
#ifndef MLRT_MLRTA_CELL_H
#define MLRT_MLRTA_CELL_H

#include "mlrta/part.h"

/* What becomes of a cell. FAILED: there is no memory, or the call is cancelled. */
enum mlrt_choice { MLRT_CHOICE_FAILED, MLRT_CHOICE_LEAF, MLRT_CHOICE_SPLIT };

/* Cuts a cell in two, if that pays. A large cell advances the progress by the work of one of the levels below it. */
enum mlrt_choice mlrt_cut_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, struct mlrt_split *split,
                               struct mlrt_kdtree_cell sides[2]);

/* Adds the children of a node, and sets *first_child to the lower one. Returns 0 if there is no memory. */
int mlrt_add_children(struct mlrt_kdtree_part *part, uint32_t node, const struct mlrt_split *split,
                      uint32_t *first_child);

/*
 * Ends the subtree of a cell, whose sides are built: sets its cost, and if it does not pay, one leaf replaces it. Its
 * entries are those from `offset` on. Returns 0 if there is no memory.
 */
int mlrt_close_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, const struct mlrt_kdtree_cell *below,
                    const struct mlrt_kdtree_cell *above, uint32_t offset);

/*
 * Builds the subtree of a cell, sets its cost, and overwrites its references. Returns 0 if there is no memory, or the
 * call is cancelled.
 */
int mlrt_build_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell);

#endif
