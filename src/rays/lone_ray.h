/* SPDX-License-Identifier: MIT */
/* One ray as it was given, and its numbers, once it is known that float carries them. */
#ifndef MLRT_RAYS_LONE_RAY_H
#define MLRT_RAYS_LONE_RAY_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/platform.h"
#include "exact/segment.h"
#include "mlrt.h"
#include "rays/ray_powers.h"

/* job/job.h */
struct mlrt_kernels;

/* Vectors are x, y, z, and z once more. */
struct mlrt_lone_ray {
    const struct mlrt_kernels *kernels; /* those that trace the ray */
    MLRT_ALIGNED(16) float origin[4];
    MLRT_ALIGNED(16) float direction[4];
    MLRT_ALIGNED(16) float reciprocal[4]; /* 1 / direction, rounded */
    float t_min;
    float t_max;
    uint32_t mask;
    uint32_t skip; /* the number of a triangle that the ray passes through, or MLRT_NONE */
    int any;       /* any hit will do */
    int in_units;  /* 1 = the vectors above are in units, and `units` is set */
    struct {
        struct mlrt_ray_powers powers;
        float begin, end; /* t_min and t_max */
    } units;
    struct {
        const float *origin;
        const float *direction;
    } given; /* the vectors as they were given, which stay until the ray is traced */
};

/* Sets a ray as it is traced in double. Returns 0 if it can hit nothing. */
static inline int mlrt_get_lone_segment(const struct mlrt_lone_ray *ray, struct mlrt_ray_segment *segment)
{
    if (!mlrt_make_segment(ray->given.origin, ray->given.direction, ray->t_min, ray->t_max, segment)) return 0;
    segment->mask = ray->mask;
    return 1;
}

/* Sets the fields of a hit that the query writes, for a miss. */
static inline void mlrt_set_miss(int any, mlrt_hit *hit)
{
    static const mlrt_hit miss = {.t = INFINITY, .mesh = MLRT_NONE, .triangle = MLRT_NONE};
    if (any) {
        hit->occluded = 0;
    } else {
        memcpy((unsigned char *)hit + offsetof(mlrt_hit, t), &miss.t, sizeof miss - offsetof(mlrt_hit, t));
    }
}

#endif
