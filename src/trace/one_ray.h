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

/* What a ray of its own is traced with. Of the worker only the fields that are set below are used. */
struct lone_search {
    struct mlrt_job job;
    struct mlrt_worker worker;
    struct mlrt_known_plane plane; /* the only one that the worker can keep */
};

/*
 * Sets what is needed to trace a ray, whose numbers are in units, through boxes: as lane 0 of *packet, which is that of
 * `scaled`, if the unit is not 1. fill_lone_packet (units.h) sets other fields where they are needed.
 */
MLRT_INLINE void begin_lone_search(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray,
                                   struct mlrt_scaled_packet *scaled, struct mlrt_packet *packet,
                                   struct lone_search *search)
{
    search->job.tree = tree;
    search->job.any = ray->any;
    packet->t_min[0] = ray->t_min;
    packet->nearest.lo[0] = packet->nearest.hi[0] = ray->t_max;
    packet->nearest.triangle[0] = MLRT_NONE;
    packet->skip[0] = ray->skip;
    packet->has.skip = ray->skip != MLRT_NONE;
    packet->has.masks = 0;
    search->worker.mask = ray->mask;
    search->worker.known.planes = &search->plane;
    search->worker.lone = ray;
    search->worker.scaled = scaled;
    CLEAR_COUNTS(&search->worker);
}

/*
 * The function `trace_ray` of job/job.h. The search is compiled once for each query, without a call: rays in calls of
 * their own are 1.04 times as fast so with AVX2, 1.06 times with AVX-512.
 */
static int32_t trace_one_ray(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    const struct ray_rows rows = rows_of_lone_ray(ray);
    struct mlrt_packet packet;
    struct lone_search search;
    if (MLRT_UNLIKELY(tree->bvh.node_count == 0)) {
        mlrt_set_result(tree, ray, MLRT_NONE, hit);
        return MLRT_OK;
    }
    begin_lone_search(tree, ray, NULL, &packet, &search);
    if (ray->any) {
        (void)trace_lane(&search.job, 1, &rows, 0, 0, &packet, &search.worker);
        hit->occluded = packet.nearest.triangle[0] != MLRT_NONE;
        return MLRT_OK;
    }
    const struct mlrt_corners corners = trace_lane(&search.job, 0, &rows, 0, 0, &packet, &search.worker);
    const uint32_t number = packet.nearest.triangle[0];
    if (number == MLRT_NONE || MLRT_UNLIKELY(!report_one_ray(&corners, ray->origin, ray->direction, hit))) {
        mlrt_set_result(tree, ray, number, hit);
        return MLRT_OK;
    }
    mlrt_find_ids(tree, number, &hit->mesh, &hit->triangle);
    hit->occluded = 1;
    return MLRT_OK;
}

/* The function `trace_ray_in_units` of job/job.h. */
static int32_t trace_one_ray_in_units(const struct mlrt_tree *tree, const struct mlrt_lone_ray *given, mlrt_hit *hit)
{
    struct mlrt_ray_segment segment;
    struct mlrt_packet packet;
    struct mlrt_scaled_packet scaled;
    struct lone_search search;
    struct mlrt_lone_ray ray = *given;
    if (tree->bvh.node_count == 0 || !mlrt_get_lone_segment(given, &segment)) {
        mlrt_set_result(tree, given, MLRT_NONE, hit);
        return MLRT_OK;
    }
    for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) { /* all lanes are brought into units */
        for (int k = 0; k < 3; ++k) {
            packet.origin[k][lane] = segment.origin[k];
            packet.direction[k][lane] = segment.direction[k];
        }
        packet.t_min[lane] = segment.t_min;
        packet.t_max[lane] = packet.nearest.lo[lane] = packet.nearest.hi[lane] = segment.t_max;
    }
    packet.nearest.triangle[0] = MLRT_NONE;
    packet.skip[0] = given->skip;
    packet.has.skip = given->skip != MLRT_NONE;
    packet.has.apex = packet.has.masks = 0;
    if (!scale_packet(1, tree->bvh.unit, tree->bvh.reach, &packet, &scaled)) return MLRT_ERROR_UNSUPPORTED;
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = scaled.rays.origin[k][0];
        ray.direction[k] = scaled.rays.direction[k][0];
        ray.reciprocal[k] = 1 / ray.direction[k];
    }
    ray.t_min = scaled.rays.t_min[0];
    ray.t_max = scaled.rays.nearest.hi[0];
    begin_lone_search(tree, &ray, &scaled, &scaled.rays, &search);
    const struct ray_rows rows = rows_of_lone_ray(&ray);
    trace_single(&search.job, &rows, 0, 0, &scaled.rays, &search.worker);
    mlrt_set_result(tree, given, scaled.rays.nearest.triangle[0], hit);
    return MLRT_OK;
}

#endif
