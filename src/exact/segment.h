/* SPDX-License-Identifier: MIT */
/* A ray as the hit rule takes it, and which rays can hit anything (rule R1). */
#ifndef MLRT_EXACT_SEGMENT_H
#define MLRT_EXACT_SEGMENT_H

#include <math.h>
#include <stdint.h>

/* A ray whose numbers have been checked. */
struct mlrt_ray_segment {
    float origin[3];
    float direction[3];
    float t_min;   /* >= 0 */
    float t_max;   /* may be inf */
    uint32_t mask; /* scene/masks.h */
};

/* Of a ray that sees all triangles. */
#define MLRT_MASK_ALL 0xFFFFFFFFu

/* Rule R1: sets *ray. Returns 0 if the ray can hit nothing. */
static inline int mlrt_make_segment(const float origin[3], const float direction[3], float t_min, float t_max,
                                    struct mlrt_ray_segment *ray)
{
    for (int k = 0; k < 3; ++k) {
        if (!isfinite(origin[k]) || !isfinite(direction[k])) return 0;
        ray->origin[k] = origin[k];
        ray->direction[k] = direction[k] + 0.0f; /* -0 becomes 0 */
    }
    if (direction[0] == 0 && direction[1] == 0 && direction[2] == 0) return 0;
    ray->t_min = t_min < 0 ? 0 : t_min;
    ray->t_max = t_max;
    ray->mask = MLRT_MASK_ALL;
    return ray->t_min < ray->t_max;
}

#endif
