/* SPDX-License-Identifier: MIT */
/* The powers of two that bring a ray into the units of boxes (bvh/unit.h), besides the unit itself. */
#ifndef MLRT_RAYS_RAY_POWERS_H
#define MLRT_RAYS_RAY_POWERS_H

#include <stdint.h>
#include <string.h>

struct mlrt_ray_powers {
    float direction;    /* brings the greatest component of the direction to 1 .. 2; or 1 */
    float time;         /* t in units is t as given times this */
    float inverse_time; /* 1 / time */
};

/* 2^(exponent_bits - 127), of a normal float */
static inline float mlrt_power_of_two(uint32_t exponent_bits)
{
    const uint32_t bits = exponent_bits << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* 1 / power, if both are normal floats */
static inline float mlrt_inverse_of_power(float power)
{
    uint32_t bits;
    memcpy(&bits, &power, sizeof bits);
    return mlrt_power_of_two(254 - (bits >> 23));
}

/* Are a float with this exponent and its reciprocal both normal? */
static inline int mlrt_is_normal_exponent(uint32_t exponent_bits)
{
    return exponent_bits - 2 <= 250;
}

/*
 * Finds the powers of a ray, given the greatest magnitude of its direction's components. Returns 0, and sets all to 1,
 * if they or their reciprocals are not normal floats.
 */
static inline int mlrt_find_ray_powers(float greatest, float unit, struct mlrt_ray_powers *powers)
{
    uint32_t bits, unit_bits;
    memcpy(&bits, &greatest, sizeof bits);
    memcpy(&unit_bits, &unit, sizeof unit_bits);
    const uint32_t exponent = bits >> 23, time = exponent + (unit_bits >> 23) - 127;
    const int is_normal = mlrt_is_normal_exponent(exponent) && mlrt_is_normal_exponent(time);
    powers->direction = is_normal ? mlrt_power_of_two(254 - exponent) : 1;
    powers->time = is_normal ? mlrt_power_of_two(time) : 1;
    powers->inverse_time = is_normal ? mlrt_power_of_two(254 - time) : 1;
    return is_normal;
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
