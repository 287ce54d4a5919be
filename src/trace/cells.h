/* SPDX-License-Identifier: MIT */
/*
 * Cells are packets or tiles of which only the hull is known, and whose rays are not made: of a camera, of a light, or
 * of the caller's arrays. These are the steps to them that need no vectors.
 */
#ifndef MLRT_TRACE_CELLS_H
#define MLRT_TRACE_CELLS_H

#include "rays/array_layout.h"
#include "rays/rectangle.h"
#include "trace/bundle.h"
#include "trace/planes.h"

/* Makes a point the waist. Returns 0 if it is not exact in units, or if float does not carry it. */
int mlrt_set_apex(const float point[3], float unit, struct mlrt_waist *waist);

/* Begins the cells `there` of a bundle: closed, all rays start at the waist, and look from there without an end. */
void mlrt_begin_cells(uint32_t there, struct mlrt_bundle *bundle);

/* What all rays of a square have in common. */
struct mlrt_array_cells {
    struct mlrt_array_reader reader;
    struct mlrt_rectangle area;
    const struct mlrt_array_layout *vectors; /* of what differs from ray to ray: directions, or points */
    const float *from;                       /* subtracted from these for hulls: the waist, not in units; NULL: 0 */
    float middle[3];                         /* the waist of parallel rays */
    int are_parallel;
    int have_ends;                             /* they end at t = 1 */
    float slope[2];                            /* of parallel rays */
    float unit;                                /* of the bundle */
    struct mlrt_box ends[MLRT_BUNDLE_PACKETS]; /* of the points e of each cell's rays: d; o if they are parallel */
};

/* Begins cells of parallel rays. Returns 0 if float does not carry them. */
int mlrt_begin_parallel_cells(const struct mlrt_bvh *bvh, struct mlrt_array_cells *cells, struct mlrt_waist *waist);

/* Likewise of rays from one point. `first` is the element of one ray, which gives the main axis. */
int mlrt_begin_apex_cells(const struct mlrt_bvh *bvh, const struct mlrt_source *source, size_t first,
                          struct mlrt_array_cells *cells, struct mlrt_waist *waist);

/*
 * A plane, as rays of cells see it. They have a point e: d if they begin at one point, o if they are parallel.
 * `distance` - normal . e is then N - D or N.
 */
struct mlrt_plane_of_cells {
    struct mlrt_plane plane;
    double distance;
    double size; /* of `distance`: what its error is relative to */
    double sign; /* +-1: of `distance` - normal . e for rays that do not reach the plane */
};

/* Sets a plane, but for the sign, which differs from cell to cell. */
void mlrt_see_plane_of_cells(const struct mlrt_array_cells *cells, const struct mlrt_triangle *triangle,
                             struct mlrt_plane_of_cells *of);

/* Where a box lies: in the plane's sign, `distance` - normal . e is at least `nearest` - `error` for its points e. */
struct mlrt_side_of_box {
    double nearest;
    double error;
};

struct mlrt_side_of_box mlrt_find_side_of_box(const struct mlrt_box *box, const struct mlrt_plane_of_cells *of);

/* Is a box on the side of a plane where rays do not reach it? */
static inline int mlrt_is_box_apart(const struct mlrt_box *box, const struct mlrt_plane_of_cells *of)
{
    const struct mlrt_side_of_box side = mlrt_find_side_of_box(box, of);
    return side.nearest > side.error;
}

#endif
