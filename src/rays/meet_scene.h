/* SPDX-License-Identifier: MIT */
/*
 * Does a ray of a call of its own meet the box of the scene? This is compiled once, in the instruction set that every
 * processor has: a ray that misses the scene needs no kernel.
 */
#ifndef MLRT_RAYS_MEET_SCENE_H
#define MLRT_RAYS_MEET_SCENE_H

#include "exact/triangle.h"
#include "mlrt.h"
#include "rays/lone_ray.h"
#include "rays/packet.h"
#include "scene/tree.h"
#include "simd/quad.h"

/* What is known of a ray that is prepared, before it is traced. */
enum mlrt_lone_ray_kind {
    MLRT_LONE_RAY_MISSES,      /* it can hit nothing (rule R1, exact/segment.h), or passes the box of the scene */
    MLRT_LONE_RAY_NOT_CARRIED, /* float does not carry its numbers, or its origin is beyond reach (scene/reach.h) */
    MLRT_LONE_RAY_MAY_HIT
};

#define LATEST_END 0x1p126f

/*
 * Compares a ray in units with the box of all triangles, and sets the numbers of *ray if it may hit one; of the vectors
 * as given it sets nothing. A float that may be read must follow the box: it is loaded, and has no meaning.
 *
 * Along each axis the ray is between the planes of the box from t = near to far, each with three roundings, and 2^-149
 * where it underflows. If the ray meets the box, the true near is at most the true far, so as computed
 * near <= far (1 + 6.01 u) + 2^-147. RECIPROCAL_SLACK is 8 u, and 2^-126 is the least float that is not denormal. Where
 * d_k is 0, a ray between the planes has the distances -inf and inf, another one has two equal ones; a ray in a plane
 * has a NaN, which f4_min and f4_max pass on in the order of operands below, and which t_min and t_max then replace.
 * Planes are at most 2^62 or infinite, so a box begins and ends at t < 2^123 or never. A ray that ends later ends at
 * LATEST_END, and so passes boxes that never begin; one that begins later begins there, and so meets those that never
 * end: they may have hits even then. For f4_are_within `reach` may be any float: no answer depends on it
 * (scene/reach.h), and what passes is below 2^60, the most that it can be.
 */
MLRT_INLINE enum mlrt_lone_ray_kind mlrt_prepare_vectors(const struct mlrt_box *box, float reach, f4 origin,
                                                         f4 direction, float given_t_min, float t_max,
                                                         struct mlrt_lone_ray *ray)
{
    if (!f4_are_within(origin, direction, MLRT_SAFE_MIN, reach)) {
        if ((f4_zeros_or_within(origin, MLRT_SAFE_MIN, reach) &
             f4_zeros_or_within(direction, MLRT_SAFE_MIN, MLRT_SAFE_MAX)) != 15) {
            return MLRT_LONE_RAY_NOT_CARRIED;
        }
        if (f4_zeros(direction) == 15) return MLRT_LONE_RAY_MISSES;
        direction = f4_add(direction, f4_set1(0)); /* -0 becomes 0 */
    }
    const f4 reciprocal = f4_div(f4_set1(1), direction);
    const f4 to_lo = f4_mul(f4_sub(f4_load_any(box->lo), origin), reciprocal);
    const f4 to_hi = f4_mul(f4_sub(f4_load_any(box->hi), origin), reciprocal);
    const float begin = given_t_min < LATEST_END ? given_t_min : LATEST_END;
    const float end = t_max < LATEST_END ? t_max : LATEST_END;
    const float near = f4_greatest_of(f4_min(to_hi, to_lo), begin);
    const float far = f4_least_of(f4_max(to_lo, to_hi), end);
    if (near > far * (1 + 2 * RECIPROCAL_SLACK) + 0x1p-126f) return MLRT_LONE_RAY_MISSES;
    const float t_min = given_t_min < 0 ? 0 : given_t_min;
    if (!(t_min < t_max)) return MLRT_LONE_RAY_MISSES;
    f4_store(ray->origin, origin);
    f4_store(ray->direction, direction);
    f4_store(ray->reciprocal, reciprocal);
    ray->t_min = t_min;
    ray->t_max = t_max;
    return MLRT_LONE_RAY_MAY_HIT;
}

/* As mlrt_prepare_lone_ray, where the unit is not 1: brings the ray into units, if that takes no rounding. */
enum mlrt_lone_ray_kind mlrt_prepare_ray_in_units(const struct mlrt_bvh *bvh, const float given_origin[3],
                                                  const float given_direction[3], float t_min, float t_max,
                                                  struct mlrt_lone_ray *ray);

/* Sets the numbers of a ray, if it may hit a triangle. */
MLRT_INLINE enum mlrt_lone_ray_kind mlrt_prepare_lone_ray(const struct mlrt_bvh *bvh, const float given_origin[3],
                                                          const float given_direction[3], float t_min, float t_max,
                                                          struct mlrt_lone_ray *ray)
{
    static const float one = 1; /* compared as bits, which takes fewer steps */
    if (MLRT_UNLIKELY(memcmp(&bvh->unit, &one, sizeof one) != 0)) {
        return mlrt_prepare_ray_in_units(bvh, given_origin, given_direction, t_min, t_max, ray);
    }
    ray->in_units = 0;
    return mlrt_prepare_vectors(&bvh->whole, bvh->reach, f4_three(given_origin), f4_three(given_direction), t_min,
                                t_max, ray);
}

#endif
