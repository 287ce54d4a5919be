/* SPDX-License-Identifier: MIT */
/*
 * The ray of a call of its own, with its results.
 */
#ifndef MLRT_TRACE_ONE_RAY_H
#define MLRT_TRACE_ONE_RAY_H

#include "hits/hit_numbers.h"
#include "job/write_arrays.h"
#include "rays/lone_ray.h"
#include "trace/single_ray.h"

/* Traces a ray through boxes whose unit is not 1. Returns 0 and sets nothing if float does not carry it into units. */
static MLRT_NOINLINE int trace_one_in_units(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray,
                                            mlrt_hit *hit)
{
    struct mlrt_ray_segment segment;
    uint32_t number = MLRT_NONE;
    if (tree->bvh.node_count > 0 && mlrt_get_lone_segment(ray, &segment) &&
        !trace_scaled_ray(tree, &segment, ray->any, ray->skip, &number)) {
        return 0;
    }
    mlrt_set_result(tree, ray, number, hit);
    return 1;
}

/* The function `trace_ray` of job/job.h. */
static int trace_one_ray(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    struct mlrt_corners corners;
    struct mlrt_hit_report report;
    if (MLRT_UNLIKELY(tree->bvh.unit != 1)) return trace_one_in_units(tree, ray, hit);
    const uint32_t number = tree->bvh.node_count > 0 ? trace_lone_ray(tree, ray, NULL, &corners) : MLRT_NONE;
    if (ray->any) {
        hit->occluded = number != MLRT_NONE;
        return 1;
    }
    if (number == MLRT_NONE || MLRT_UNLIKELY(!report_one_ray(&corners, ray->origin, ray->direction, &report))) {
        mlrt_set_result(tree, ray, number, hit);
        return 1;
    }
    mlrt_find_ids(tree, number, &hit->mesh, &hit->triangle);
    hit->t = report.t;
    hit->u = report.u;
    hit->v = report.v;
    hit->facing = report.facing;
    hit->occluded = 1;
    return 1;
}

#endif
