/* SPDX-License-Identifier: MIT */
/* One ray of a call of its own, with numbers that float carries. */
#ifndef MLRT_RAYS_LONE_RAY_H
#define MLRT_RAYS_LONE_RAY_H

#include <stdint.h>

#include "base/platform.h"

/* job/job.h */
struct mlrt_kernels;

/* Vectors are x, y, z, and z once more. */
struct mlrt_lone_ray {
    const struct mlrt_kernels *kernels; /* those that trace the ray; NULL = the widest */
    MLRT_ALIGNED(16) float origin[4];
    MLRT_ALIGNED(16) float direction[4];
    MLRT_ALIGNED(16) float reciprocal[4]; /* 1 / direction, rounded */
    float t_min;
    float t_max;
    uint32_t mask;
    uint32_t skip; /* the number of a triangle that the ray passes through, or MLRT_NONE */
    int any;       /* any hit will do */
    /* The vectors as they were given. They stay until the ray is traced. */
    const float *given_origin;
    const float *given_direction;
};

#endif
