/* SPDX-License-Identifier: MIT */
/*
 * Where to split a cell: the surface area heuristic and the rules of the paper that come before it. Pure functions:
 * they look at the references of one cell and keep nothing. Those that are given a call's progress look whether it is
 * to end, and if so, do; then what they say means nothing. Less than MLRT_ROUNDS references are not worth a look.
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

/* A triangle in a cell: `box` holds the part of it that lies in the cell, and is in the cell. */
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
    double cost; /* of a ray that crosses the cell, by the model; HUGE_VAL = there is no split */
    float position;
    uint32_t axis;
    int planar_above; /* 1 = references planar in the plane go to the upper side */
};

/* What the references of a cell have in common. */
struct mlrt_content {
    struct mlrt_box bounds;
    double planar_area[3]; /* of the boxes that are planar in each axis, together */
};

/* Keys sort as unsigned integers like the floats they stand for. */
uint32_t mlrt_float_key(float x);

/* Sorts `count` keys ascending; `spare` has room for as many. */
void mlrt_sort_keys(uint32_t *keys, uint32_t *spare, size_t count);

/* Half the surface area of a box, finite for all floats. */
double mlrt_half_area(const struct mlrt_box *box);

/* -1, 0, +1: a reference lies below, on both sides of, above the split. */
static inline int mlrt_side_of_split(const struct mlrt_reference *reference, const struct mlrt_split *split)
{
    float lo = reference->box.lo[split->axis], hi = reference->box.hi[split->axis];
    if (lo == hi && lo == split->position) return split->planar_above ? 1 : -1;
    return (lo >= split->position) - (hi <= split->position);
}

/* What a split costs by the model that leaves so many references on its sides. Not for cells of zero area. */
double mlrt_split_cost(const struct mlrt_cost_model *model, const struct mlrt_box *cell, const struct mlrt_split *split,
                       size_t below_count, size_t above_count);

struct mlrt_content mlrt_measure_content(const struct mlrt_reference *references, size_t count,
                                         struct mlrt_progress *progress);

/*
 * Rule 1: the split that cuts off the largest empty side, if it is more than 10 % of the cell. Returns whether it is;
 * the cost is not set.
 */
int mlrt_find_empty_side(const struct mlrt_box *cell, const struct mlrt_box *content, struct mlrt_split *split);

/* Whether rule 2 may find a plane: enough area is planar in some axis. */
int mlrt_may_be_covered(const struct mlrt_box *cell, const struct mlrt_content *content);

/*
 * Rule 2: a plane that triangles in it cover wholly; of several the one nearest to the middle of the cell. `keys` has
 * room for 2 * count, `areas` for count. Returns whether there is one; the cost is not set.
 */
int mlrt_find_covered_plane(const struct mlrt_triangle *triangles, const struct mlrt_box *cell,
                            const struct mlrt_reference *references, size_t count, const struct mlrt_content *content,
                            struct mlrt_progress *progress, uint32_t *keys, double *areas, struct mlrt_split *split);

/* The cheapest split at a bound of any reference. `keys` has room for 3 * count. */
void mlrt_find_exact_split(const struct mlrt_cost_model *model, const struct mlrt_box *cell,
                           const struct mlrt_reference *references, size_t count, uint32_t *keys,
                           struct mlrt_split *split);

/*
 * The same for many references: the cheapest of a row of equidistant planes is looked for first, and then the cheapest
 * bound of a reference around it. The counts it goes by are exact. `keys` has room for 3 * count.
 */
void mlrt_find_binned_split(const struct mlrt_cost_model *model, const struct mlrt_box *cell,
                            const struct mlrt_reference *references, size_t count, const struct mlrt_box *content,
                            struct mlrt_progress *progress, uint32_t *keys, struct mlrt_split *split);

#endif
