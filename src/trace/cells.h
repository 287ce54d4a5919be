/* SPDX-License-Identifier: MIT */
/*
 * Cells without rays, of cameras and of points: the steps that need no vectors.
 */
#ifndef MLRT_TRACE_CELLS_H
#define MLRT_TRACE_CELLS_H

#include "rays/rectangle.h"
#include "trace/bundle.h"
#include "trace/ray_tile.h"

/* Makes a point the waist. Returns 0 if it is not exact in units, or if float does not carry it. */
int mlrt_set_apex(const float point[3], float unit, struct mlrt_waist *waist);

/* A camera's cells before their slopes are bounded. */
struct mlrt_camera_samples {
    struct mlrt_view view; /* with directions that are brought near 1, if the unit of boxes is not 1 */
    uint32_t all;          /* the cells that exist */
    float pad[3];          /* what a component of a direction may be off by: see gather_camera_cells */
    /* Of each cell, the first and the last column, and the first and the last row. */
    MLRT_ALIGNED(64) float positions[4][MLRT_CELL_COUNT];
};

/*
 * Sets the waist, and the samples of the cells of `side` x `side` pixels that `area` consists of. Returns 0 if the rays
 * are parallel, have limits of t, or if float does not carry them.
 */
int mlrt_sample_camera_cells(const struct mlrt_view *view, float unit, const struct mlrt_rectangle *area, uint32_t side,
                             struct mlrt_waist *waist, struct mlrt_camera_samples *of);

#endif
