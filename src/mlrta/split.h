/* SPDX-License-Identifier: MIT */
/*
 * Where to split a cell: the surface area heuristic, and the rules of the paper that come before it. The functions read
 * the references of one cell and keep no state. They end early if the call is cancelled; then their results mean
 * nothing. They check every MLRT_ROUNDS references, so never in smaller cells.
 *
 * Based on: Alexander Reshetov, Alexei Soupikov, Jim Hurley, "Multi-Level Ray Tracing Algorithm", 2005, section 3.1.
 * Ingo Wald, Vlastimil Havran, "On building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)", 2006.
 * Maxim Shevtsov, Alexei Soupikov, Alexander Kapustin, "Highly Parallel Fast KD-tree Construction for Interactive Ray
 * Tracing of Dynamic Scenes", 2007 (min/max binning).
 *
 * A reference whose box is flat in an axis is called planar there. It goes to one side of a plane that it lies in.
 */
#ifndef MLRT_MLRTA_SPLIT_H
#define MLRT_MLRTA_SPLIT_H

#include "base/progress.h"
#include "exact/triangle.h"

/* A triangle in a cell. `box` lies in the cell and contains the part of the triangle that does. */
struct mlrt_reference {
    uint32_t triangle;
    struct mlrt_box box;
};

struct mlrt_cost_model {
    double traversal;    /* of a node step */
    double intersection; /* of a triangle test */
    double empty_factor; /* of a split with an empty side: 1 = no bonus */
};

struct mlrt_split {
    double cost; /* expected for a ray that crosses the cell; HUGE_VAL = there is no split */
    float position;
    uint32_t axis;
    int planar_above; /* 1 = references planar in the plane go to the upper side */
};

/* What is in a cell. */
struct mlrt_content {
    const struct mlrt_box *cell;
    const struct mlrt_reference *references;
    size_t count;
    struct mlrt_progress *progress; /* may be NULL */
    struct mlrt_box bounds;         /* of all references */
    double planar_area[3];          /* the sum over the boxes that are planar in this axis */
};

/* Half the surface area of a box, finite for all floats. */
double mlrt_half_area(const struct mlrt_box *box);

/* -1, 0, +1: a reference lies below, on both sides of, above the split. */
static inline int mlrt_side_of_split(const struct mlrt_reference *reference, const struct mlrt_split *split)
{
    float lo = reference->box.lo[split->axis], hi = reference->box.hi[split->axis];
    if (lo == hi && lo == split->position) return split->planar_above ? 1 : -1;
    return (lo >= split->position) - (hi <= split->position);
}

/* The cost of a split that leaves these counts of references on its sides. The cell must have an area above 0. */
double mlrt_split_cost(const struct mlrt_cost_model *model, const struct mlrt_box *cell, const struct mlrt_split *split,
                       size_t below_count, size_t above_count);

/* Measures the content of a cell of at least one reference. */
struct mlrt_content mlrt_measure_content(const struct mlrt_box *cell, const struct mlrt_reference *references,
                                         size_t count, struct mlrt_progress *progress);

/*
 * Rule 1: the split that cuts off the largest empty side, if that is more than 10 % of the cell. Returns 1 if there is
 * one. Does not set the cost.
 */
int mlrt_find_empty_side(const struct mlrt_content *content, struct mlrt_split *split);

/*
 * Rule 2: a plane that the triangles in it cover wholly; of several, the one nearest to the middle of the cell. `keys`
 * has room for 2 * count, `areas` for count. Returns 1 if there is one. Does not set the cost.
 */
int mlrt_find_covered_plane(const struct mlrt_triangle *triangles, const struct mlrt_content *content, uint32_t *keys,
                            double *areas, struct mlrt_split *split);

/* The cheapest split at a bound of any reference. `keys` has room for 3 * count. */
void mlrt_find_exact_split(const struct mlrt_cost_model *model, const struct mlrt_content *content, uint32_t *keys,
                           struct mlrt_split *split);

/*
 * The same for many references: finds the cheapest of equidistant planes first, then the cheapest bound of a reference
 * near it. The counts on either side are exact. `keys` has room for 3 * count.
 */
void mlrt_find_binned_split(const struct mlrt_cost_model *model, const struct mlrt_content *content, uint32_t *keys,
                            struct mlrt_split *split);

#endif
