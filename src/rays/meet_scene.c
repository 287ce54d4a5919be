/* SPDX-License-Identifier: MIT */
/* See meet_scene.h. */
#include "rays/meet_scene.h"

static int are_near_one(f4 direction)
{
    return f4_are_within(direction, direction, 0x1p-20f, 0x1p20f);
}

enum mlrt_lone_ray_kind mlrt_prepare_ray_in_units(const struct mlrt_bvh *bvh, const float given_origin[3],
                                                  const float given_direction[3], float t_min, float t_max,
                                                  struct mlrt_lone_ray *ray)
{
    const f4 as_given = f4_three(given_origin), origin = f4_mul(as_given, f4_set1(bvh->unit));
    const f4 given = f4_three(given_direction);
    const f4 times_unit = f4_mul(given, f4_set1(bvh->unit));
    f4 direction;
    t_min = t_min < 0 ? 0 : t_min;
    if (!(t_min < t_max)) return MLRT_LONE_RAY_MISSES;
    /* Two usual kinds of rays, since the greatest component takes long to find: lengths near 1, and those of scenes. */
    if (are_near_one(given)) {
        direction = given;
        ray->units.powers = (struct mlrt_ray_powers){1, bvh->unit};
    } else if (are_near_one(times_unit)) {
        direction = times_unit;
        ray->units.powers = (struct mlrt_ray_powers){bvh->unit, 1};
    } else {
        if (!mlrt_find_ray_powers(f4_greatest_of(f4_abs(given), 0), bvh->unit, &ray->units.powers)) {
            return MLRT_LONE_RAY_NOT_CARRIED;
        }
        direction = f4_mul(given, f4_set1(ray->units.powers.direction));
    }
    /* A product with a power of 2 rounds only if it is denormal or 0. mlrt_prepare_vectors wants normal floats or 0. */
    if (f4_zeros(origin) != f4_zeros(as_given) || f4_zeros(direction) != f4_zeros(given)) {
        return MLRT_LONE_RAY_NOT_CARRIED;
    }
    mlrt_scale_range(t_min, t_max, ray->units.powers.time, &ray->units.begin, &ray->units.end);
    if (ray->units.begin > LATEST_END) return MLRT_LONE_RAY_NOT_CARRIED;
    const enum mlrt_lone_ray_kind kind =
        mlrt_prepare_vectors(&bvh->whole, bvh->reach, origin, direction, ray->units.begin, ray->units.end, ray);
    ray->t_min = t_min;
    ray->t_max = t_max;
    ray->in_units = 1;
    return kind;
}
