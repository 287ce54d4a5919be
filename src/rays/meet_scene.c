/* SPDX-License-Identifier: MIT */
/* See meet_scene.h. */
#include "rays/meet_scene.h"

enum mlrt_lone_ray_kind mlrt_take_ray_in_units(const struct mlrt_bvh *bvh, const float given_origin[3],
                                               const float given_direction[3], float t_min, float t_max,
                                               struct mlrt_lone_ray *ray)
{
    const float unit = bvh->unit, inverse = 1 / unit;
    const f4 as_given = f4_three(given_origin), origin = f4_mul(as_given, f4_set1(unit));
    const f4 given = f4_three(given_direction);
    struct mlrt_ray_powers powers;
    float begin, end;
    t_min = t_min < 0 ? 0 : t_min;
    if (!(t_min < t_max)) return MLRT_LONE_RAY_MISSES;
    if (f4_are_within(given, given, 0x1p-20f,
                      0x1p20f)) { /* stays as it is: its greatest component takes long to find */
        powers = (struct mlrt_ray_powers){1, unit, inverse};
    } else if (!mlrt_find_ray_powers(f4_greatest_of(f4_abs(given), 0), unit, &powers)) {
        return MLRT_LONE_RAY_NOT_CARRIED;
    }
    const f4 direction = f4_mul(given, f4_set1(powers.direction));
    const f4 rounding = f4_sub(f4_mul(origin, f4_set1(inverse)), as_given);
    if (f4_zeros(rounding) != 15 || f4_zeros(direction) != f4_zeros(given)) return MLRT_LONE_RAY_NOT_CARRIED;
    mlrt_scale_range(t_min, t_max, powers.time, &begin, &end);
    if (begin > LATEST_END) return MLRT_LONE_RAY_NOT_CARRIED;
    const enum mlrt_lone_ray_kind kind = mlrt_take_vectors(&bvh->whole, bvh->reach, origin, direction, begin, end, ray);
    ray->t_min = t_min;
    ray->t_max = t_max;
    ray->in_units = 1;
    ray->powers = powers;
    return kind;
}
