/* SPDX-License-Identifier: MIT */
/*
 * A camera's packets, or its tiles, as a bundle without rays: each is a rectangle of slopes.
 */
#ifndef MLRT_TRACE_CAMERA_CELLS_H
#define MLRT_TRACE_CAMERA_CELLS_H

#include "rays/camera.h"
#include "rays/rectangle.h"
#include "trace/bundle.h"

/*
 * Makes a bundle of the cells of `side` x `side` pixels that `area` of a pinhole camera's picture consists of. Returns
 * 0 if the rays have limits of t or no main axis in common, or if float does not carry them.
 */
int mlrt_gather_camera_cells(const mlrt_camera *view, float unit, const struct mlrt_rectangle *area, uint32_t side,
                             struct mlrt_bundle *bundle);

#endif
