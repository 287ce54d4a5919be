/* SPDX-License-Identifier: MIT */
/*
 * A lone ray, that of a call of its own (rays/lone_ray.h), through the hierarchy of boxes, and its results.
 */
#ifndef MLRT_TRACE_LONE_RAY_H
#define MLRT_TRACE_LONE_RAY_H

#include <float.h>

#include "hits/hit_numbers.h"
#include "job/set_hit.h"
#include "rays/lone_ray.h"
#include "scene/triangle_numbers.h"
#include "trace/single_ray.h"

/* What a lone ray is traced with. Of the worker only the fields that are set below are used. */
struct lone_search {
    struct mlrt_job job;
    struct mlrt_worker worker;
    struct mlrt_known_plane plane; /* the only one that the worker can keep */
    struct mlrt_scaled_packet scaled;
    struct mlrt_packet given; /* if the ray is in units: the ray as it was given */
};

/*
 * Sets what is needed to trace a ray through boxes, as lane 0 of the packet of search->scaled. fill_lone_packet
 * (units.h) sets other fields where they are needed.
 */
MLRT_INLINE void begin_lone_search(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray,
                                   struct lone_search *search)
{
    struct mlrt_packet *packet = &search->scaled.rays;
    float begin = ray->t_min, end = ray->t_max;
    search->worker.scaled = NULL;
    if (MLRT_UNLIKELY(ray->in_units)) {
        begin = ray->units.begin;
        end = ray->units.end;
        search->scaled.given = &search->given;
        search->worker.scaled = &search->scaled;
    }
    search->job.tree = tree;
    search->job.any = ray->any;
    packet->t_min[0] = begin;
    packet->nearest.lo[0] = packet->nearest.hi[0] = end;
    packet->nearest.triangle[0] = MLRT_NONE;
    packet->skip[0] = ray->skip;
    packet->has.skip = ray->skip != MLRT_NONE;
    packet->has.masks = 0;
    search->worker.mask = ray->mask;
    search->worker.known.planes = &search->plane;
    search->worker.lone = ray;
    CLEAR_COUNTS(&search->worker);
}

/*
 * Brings t of a hit back from units. Returns 0 if it may round otherwise there: powers of two commute with rounding
 * where both numbers are normal. A number that is rounded to FLT_MIN may lie below it, where floats are farther apart.
 */
MLRT_INLINE int leave_units(const struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    const float t = hit->t / ray->units.powers.time;
    const int is_normal = hit->t > FLT_MIN && hit->t <= FLT_MAX && t > FLT_MIN && t <= FLT_MAX;
    hit->t = t;
    return is_normal;
}

/*
 * The function `trace_ray` of job/job.h. The search is compiled once for each query, without a call: rays in calls of
 * their own are 1.04 times as fast so with AVX2, 1.06 times with AVX-512.
 */
static int32_t trace_lone_ray(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    const struct ray_rows rows = rows_of_lone_ray(ray);
    struct lone_search search;
    struct mlrt_packet *packet = &search.scaled.rays;
    if (MLRT_UNLIKELY(tree->bvh.node_count == 0)) {
        mlrt_set_result(tree, ray, MLRT_NONE, hit);
        return MLRT_OK;
    }
    begin_lone_search(tree, ray, &search);
    if (ray->any) {
        (void)trace_lane(&search.job, 1, &rows, 0, 0, packet, &search.worker);
        hit->occluded = packet->nearest.triangle[0] != MLRT_NONE;
        return MLRT_OK;
    }
    const struct mlrt_corners corners = trace_lane(&search.job, 0, &rows, 0, 0, packet, &search.worker);
    const uint32_t number = packet->nearest.triangle[0];
    if (number == MLRT_NONE || MLRT_UNLIKELY(!report_lone_ray(&corners, ray->origin, ray->direction, hit)) ||
        (MLRT_UNLIKELY(ray->in_units) && !leave_units(ray, hit))) {
        mlrt_set_result(tree, ray, number, hit);
        return MLRT_OK;
    }
    mlrt_find_ids(tree, number, &hit->mesh, &hit->triangle);
    hit->occluded = 1;
    return MLRT_OK;
}

#endif
