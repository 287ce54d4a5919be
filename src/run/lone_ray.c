/* SPDX-License-Identifier: MIT */
/*
 * One ray of a call of its own: see lone_ray.h. The paths of rays that miss the scene call no function and keep no
 * registers.
 */
#include "run/lone_ray.h"

#include <math.h>

#include "job/job.h"
#include "rays/meet_scene.h"
#include "run/dispatch.h"
#include "scene/tree.h"

static float limit_of(const mlrt_ray *ray)
{
    return ray->t_max == 0 ? INFINITY : ray->t_max;
}

/* Sets the fields of a hit that the query writes, for a miss. */
MLRT_INLINE void set_miss(int any, mlrt_hit *hit)
{
    hit->occluded = 0;
    if (any) return;
    hit->t = INFINITY;
    hit->u = hit->v = 0;
    hit->mesh = hit->triangle = MLRT_NONE;
    hit->facing = 0;
}

/* Likewise for triangle `number` or MLRT_NONE. */
static void set_result(const mlrt_tree *tree, const mlrt_ray *ray, uint32_t number, int any, mlrt_hit *hit)
{
    if (number == MLRT_NONE) {
        set_miss(any, hit);
        return;
    }
    hit->occluded = 1;
    if (!any) mlrt_set_hit(tree, ray, number, hit);
}

void mlrt_trace_by_ray(const mlrt_tree *tree, const mlrt_ray *ray, int any, uint32_t mask, uint32_t skip,
                       mlrt_counters *counters, mlrt_hit *hit)
{
    struct mlrt_ray_segment segment;
    uint32_t number = MLRT_NONE;
    if (counters) ++counters->ray_count;
    if (mlrt_make_segment(ray->origin, ray->direction, ray->t_min, limit_of(ray), &segment)) {
        segment.mask = mask;
        if (counters) ++counters->packet_count;
        number = tree->structure->tracer.trace_ray(tree, &segment, skip, any, NULL, counters);
    }
    set_result(tree, ray, number, any, hit);
}

static const struct mlrt_kernels *kernels_of(const mlrt_tree *tree, const struct mlrt_lone_ray *ray)
{
    return ray->kernels ? ray->kernels : mlrt_widest_kernels(tree->structure);
}

/* These, too, return 1 if no flag but inexact was raised. */

/* Traces one ray in double. */
static MLRT_NOINLINE int trace_in_double(const mlrt_tree *tree, const mlrt_ray *given, const struct mlrt_lone_ray *ray,
                                         mlrt_hit *hit)
{
    mlrt_trace_by_ray(tree, given, ray->any, ray->mask, ray->skip, NULL, hit);
    return 0;
}

/* Traces one ray through boxes whose unit is not 1. */
static MLRT_NOINLINE int trace_in_units(const mlrt_tree *tree, const mlrt_ray *given, const struct mlrt_lone_ray *ray,
                                        mlrt_hit *hit)
{
    struct mlrt_ray_segment segment;
    uint32_t number = MLRT_NONE;
    if (tree->bvh.node_count > 0 &&
        mlrt_make_segment(given->origin, given->direction, given->t_min, limit_of(given), &segment)) {
        segment.mask = ray->mask;
        if (!kernels_of(tree, ray)->trace_scaled_ray(tree, &segment, ray->any, ray->skip, &number)) {
            return trace_in_double(tree, given, ray, hit);
        }
    }
    set_result(tree, given, number, ray->any, hit);
    return 0;
}

/* Traces one ray that meets the box of the scene. */
static MLRT_NOINLINE int trace_in_scene(const mlrt_tree *tree, const mlrt_ray *given, const struct mlrt_lone_ray *ray,
                                        mlrt_hit *hit)
{
    const struct mlrt_kernels *kernels = kernels_of(tree, ray);
    struct mlrt_corners corners;
    struct mlrt_hit_report report;
    const uint32_t number = tree->bvh.node_count > 0 ? kernels->trace_ray(tree, ray, &corners) : MLRT_NONE;
    if (number == MLRT_NONE || ray->any || !kernels->reports ||
        MLRT_UNLIKELY(!kernels->reports->report_ray(&corners, ray->origin, ray->direction, &report))) {
        set_result(tree, given, number, ray->any, hit);
        return 0;
    }
    mlrt_find_ids(tree, number, &hit->mesh, &hit->triangle);
    hit->t = report.t;
    hit->u = report.u;
    hit->v = report.v;
    hit->facing = report.facing;
    hit->occluded = 1;
    return 0;
}

int mlrt_trace_lone_ray(const mlrt_tree *tree, const mlrt_ray *given, struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    if (MLRT_UNLIKELY(tree->bvh.unit != 1)) {
        return trace_in_units(tree, given, ray, hit);
    }
    switch (mlrt_take_lone_ray(given, &tree->bvh.whole, ray)) {
    case MLRT_LONE_RAY_MAY_HIT:
        return trace_in_scene(tree, given, ray, hit);
    case MLRT_LONE_RAY_NOT_CARRIED:
        return trace_in_double(tree, given, ray, hit);
    case MLRT_LONE_RAY_QUIET_MISS:
        set_miss(ray->any, hit);
        return 1;
    default:
        set_miss(ray->any, hit);
        return 0;
    }
}
