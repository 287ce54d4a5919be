/* SPDX-License-Identifier: MIT */
/*
 * Limits of slopes, and of |d_main|, as seen from an apex or a waist, for the kernels and for the files that make
 * cells.
 */
#ifndef MLRT_RAYS_SLOPE_LIMITS_H
#define MLRT_RAYS_SLOPE_LIMITS_H

#include "mlrt.h"

/*
 * Bounds of slopes are moved apart by this share of themselves: more than what roundings change (trace/ray_hulls.h,
 * trace/outline.h, mlrta/outline.h).
 */
#define SLOPE_SLACK 0x1p-20f

/* The greatest slope of cells, so that for all their rays the main axis is nearly that of the largest |d_k|. */
#define STEEPEST_SLOPE 2.0f

/*
 * Bounds of slopes of cells without rays are moved apart by this as well, since a slope may be denormal: see
 * trace/corner_slopes.h.
 */
#define SLOPE_FLOOR 0x1p-100f

/* The pace of a ray is |d_main| in units. In a bundle it is between these: t is divided and multiplied by it. */
#define LEAST_PACE    0x1p-125f
#define GREATEST_PACE 0x1p125f

/* The least slope besides 0: SLOPE_SLACK of much smaller ones underflows. */
#define LEAST_SLOPE 0x1p-100f

#endif
