/* SPDX-License-Identifier: MIT */
/*
 * What slopes as seen from an apex are held against, by the kernels and by who makes cells for them.
 */
#ifndef MLRT_RAYS_SLOPES_H
#define MLRT_RAYS_SLOPES_H

#include "mlrt.h"

/* Slopes are moved apart by this part of themselves: more than what roundings change (trace/hulls.h,
 * trace/outline.h, mlrta/outline.h). */
#define SLOPE_SLACK 0x1p-20f

/* Slopes of cells are at most this: the main axis is nearly the main one for all their rays. */
#define STEEPEST_SLOPE 2.0f

/* What slopes of cells without rays are moved apart at least: see gather_camera_cells. */
#define SLOPE_FLOOR 0x1p-100f

#endif
