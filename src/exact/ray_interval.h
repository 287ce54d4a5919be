/* SPDX-License-Identifier: MIT */
/*
 * The t at which one ray crosses planes, in double: single rays test nodes with it (mlrta/ray.c, bvh/ray.c).
 *
 * For finite floats nothing overflows or underflows in double here. With x = fl(c - o) and r = fl(1 / d), the distance
 * to a plane is x r with a relative error below 3 * 2^-53 (1 + 2^-50), so [x r (1 - 2^-50), x r (1 + 2^-50)] contains
 * it. A node is left out only if its interval is certainly empty or certainly behind the nearest hit.
 */
#ifndef MLRT_EXACT_RAY_INTERVAL_H
#define MLRT_EXACT_RAY_INTERVAL_H

#include <math.h>

#include "base/platform.h"
#include "exact/segment.h"

#define MLRT_INTERVAL_SLACK 0x1p-50

struct mlrt_interval {
    double enter;
    double exit;
};

/* 1 / d_k. 0 where d_k is 0: along such an axis there is no distance to a plane, and callers compare coordinates. */
MLRT_INLINE void mlrt_reciprocal_direction(const struct mlrt_ray_segment *ray, double reciprocal[3])
{
    for (int k = 0; k < 3; ++k) reciprocal[k] = ray->direction[k] == 0 ? 0 : 1.0 / ray->direction[k];
}

/* An interval that contains the t at which the ray crosses the plane x_k = c; d_k is not 0. */
MLRT_INLINE struct mlrt_interval mlrt_plane_distance(double c, double origin, double reciprocal)
{
    const double t = (c - origin) * reciprocal;
    const double slack = fabs(t) * MLRT_INTERVAL_SLACK;
    return (struct mlrt_interval){t - slack, t + slack};
}

#endif
