/* SPDX-License-Identifier: MIT */
/* The powers of two that bring a ray into the units of boxes (bvh/unit.h), besides the unit itself. */
#ifndef MLRT_RAYS_RAY_POWERS_H
#define MLRT_RAYS_RAY_POWERS_H

#include <stdint.h>
#include <string.h>

/* direction * time is the unit. */
struct mlrt_ray_powers {
    float direction; /* times this, the direction has a greatest component near 1: of 2^-20 .. 2^20, mostly of 1 .. 2 */
    float time;      /* t in units is t as given times this */
};

/* Powers of two within LEAST and its reciprocal are normal floats, as are their reciprocals. */
#define MLRT_LEAST_RAY_POWER 0x1p-125f

/* The greatest power of two that is at most x, a positive normal float. Other numbers give 0 or inf. */
static inline float mlrt_power_within(float x)
{
    uint32_t bits;
    float power;
    memcpy(&bits, &x, sizeof bits);
    bits &= 0x7F800000u;
    memcpy(&power, &bits, sizeof power);
    return power;
}

static inline int mlrt_is_ray_power(float power)
{
    return power >= MLRT_LEAST_RAY_POWER && power <= 1 / MLRT_LEAST_RAY_POWER;
}

/*
 * Finds the powers of a ray, given the greatest magnitude of its direction's components. Returns 0 if they or their
 * reciprocals are not normal floats.
 */
static inline int mlrt_find_ray_powers(float greatest, float unit, struct mlrt_ray_powers *powers)
{
    const float power = mlrt_power_within(greatest), time = power * unit;
    *powers = (struct mlrt_ray_powers){1 / power, time};
    return mlrt_is_ray_power(power) && mlrt_is_ray_power(time);
}

/* Underflow changes t in units by less than this. It is negligible beside DISTANCE_FLOOR (hits/triangle_filter.h). */
#define MLRT_TIME_SPARE 0x1p-126f

/* Sets *begin and *end to a range of t in units, made wider by MLRT_TIME_SPARE. */
static inline void mlrt_scale_range(float t_min, float t_max, float time, float *begin, float *end)
{
    const float least = t_min * time - MLRT_TIME_SPARE;
    *begin = least > 0 ? least : 0;
    *end = t_max * time + MLRT_TIME_SPARE;
}

#endif
