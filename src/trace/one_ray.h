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

/*
 * Traces a ray, whose numbers are in units, through boxes: as lane 0 of *packet, which is that of `scaled`, if the unit
 * is not 1. Returns where the corners of its hit lie. The worker is one of this call, of which only the fields set here
 * are used, with room for one plane; fill_lone_packet (units.h) sets others where they are
 * needed.
 */
MLRT_INLINE struct mlrt_corners trace_as_lane(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray,
                                              struct mlrt_scaled_packet *scaled, struct mlrt_packet *packet)
{
    const struct ray_rows rows = {ray->origin, ray->direction, ray->reciprocal, 1, 1};
    struct mlrt_known_plane plane;
    struct mlrt_worker worker;
    struct mlrt_job job;
    job.tree = tree;
    job.any = ray->any;
    packet->t_min[0] = ray->t_min;
    packet->nearest.lo[0] = packet->nearest.hi[0] = ray->t_max;
    packet->nearest.triangle[0] = MLRT_NONE;
    packet->skip[0] = ray->skip;
    packet->has.skip = ray->skip != MLRT_NONE;
    packet->has.masks = 0;
    worker.mask = ray->mask;
    worker.known.planes = &plane;
    worker.lone = ray;
    worker.scaled = scaled;
    CLEAR_COUNTS(&worker);
    return trace_single(&job, &rows, 0, 0, packet, &worker);
}

/* The function `trace_ray` of job/job.h. */
static int32_t trace_one_ray(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    struct mlrt_packet packet;
    if (MLRT_UNLIKELY(tree->bvh.node_count == 0)) {
        mlrt_set_result(tree, ray, MLRT_NONE, hit);
        return MLRT_OK;
    }
    const struct mlrt_corners corners = trace_as_lane(tree, ray, NULL, &packet);
    const uint32_t number = packet.nearest.triangle[0];
    if (ray->any) {
        hit->occluded = number != MLRT_NONE;
        return MLRT_OK;
    }
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
    if (!scale_packet(1, tree->bvh.unit, &packet, &scaled)) return MLRT_ERROR_UNSUPPORTED;
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = scaled.rays.origin[k][0];
        ray.direction[k] = scaled.rays.direction[k][0];
        ray.reciprocal[k] = 1 / ray.direction[k];
    }
    ray.t_min = scaled.rays.t_min[0];
    ray.t_max = scaled.rays.nearest.hi[0];
    (void)trace_as_lane(tree, &ray, &scaled, &scaled.rays);
    mlrt_set_result(tree, given, scaled.rays.nearest.triangle[0], hit);
    return MLRT_OK;
}

#endif
