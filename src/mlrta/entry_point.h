/* SPDX-License-Identifier: MIT */
/*
 * Entry-point search: the deepest node at which every ray of a beam may start.
 *
 * First, a depth-first search, near child first, finds the first leaf with potential: a leaf that holds triangles and
 * that the beam may touch. A bifurcation, a node with two children that the beam may reach, goes on a LIFO stack; where
 * a leaf has no potential, the search goes on with the far child of the last bifurcation. If a triangle of the leaf
 * covers the beam, hits behind it decide nothing, and the beam's region ends there. Then the far children of the
 * bifurcations left on the stack are searched, the highest bifurcation first. The first that leads to another leaf with
 * potential is the entry point; if none does, the first leaf is.
 *
 * The paper takes bifurcations from the deepest up and lets each success replace its candidate. The result is the same,
 * the highest one; from the highest down, the first success ends the search. docs/reproduction.md has the steps of
 * both.
 *
 * The search is compiled once: it works on a beam, not on vectors of rays. It always counts (`counters` is not NULL),
 * since one search is for all rays of a tile.
 *
 * Based on: Reshetov et al. 2005, section 4.1.
 */
#ifndef MLRT_MLRTA_ENTRY_POINT_H
#define MLRT_MLRTA_ENTRY_POINT_H

#include "mlrta/beam.h"
#include "mlrta/kdtree.h"
#include "mlrta/setups.h"

struct mlrt_job;

/* A node at which rays may start, and a box that contains the part of its cell that they have to search. */
struct entry_point {
    uint32_t node;
    uint32_t depth;
    struct mlrt_box box;
};

#define ENTRY_LIST_LEAVES 16
#define ENTRY_LIST_SIZE   (ENTRY_LIST_LEAVES + MLRT_DEPTH_LIMIT)

/*
 * Where the packets of a tile start: one node, or several, mostly leaves. Each ray meets them in the order of the list.
 */
struct entry_list {
    uint32_t count;
    uint32_t axis_code; /* of the outlines; NO_OUTLINES if there are none */
    struct entry_point entries[ENTRY_LIST_SIZE];
    struct mlrt_outline outlines[ENTRY_LIST_SIZE]; /* of the entries' boxes; the search does not set them */
};

#define NO_OUTLINES 3 /* the axis code of no group */

/*
 * Searches from *entry, where all rays of the beam may start. Returns 1 if *entry has become the deepest such node,
 * with the part of its cell that is in the beam's region. Returns 0 if the beam is done: *cover is the triangle on
 * which all rays have their first hit, or MLRT_NONE if none hits a triangle.
 */
int mlrt_find_entry_point(const struct mlrt_job *job, struct mlrt_beam *beam, struct entry_point *entry,
                          uint32_t *cover, mlrt_counters *counters);

/*
 * The same, but `list` receives all leaves with potential, front to back, in place of the node above them: the search
 * goes on behind each leaf as if that had no potential. Once there are ENTRY_LIST_LEAVES leaves, the far children of
 * the bifurcations still on the stack join the list unsearched. The list has no outlines yet.
 */
int mlrt_find_entry_list(const struct mlrt_job *job, struct mlrt_beam *beam, struct entry_point from,
                         struct entry_list *list, uint32_t *cover, mlrt_counters *counters);

#endif
