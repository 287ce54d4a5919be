/* SPDX-License-Identifier: MIT */
/*
 * Rays one by one: see lone_ray.h. The paths of rays that miss the scene call no function and keep no registers.
 */
#include "run/lone_ray.h"

#include "job/job.h"
#include "rays/meet_scene.h"
#include "run/dispatch.h"
#include "scene/tree.h"

void mlrt_trace_by_ray(const mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_counters *counters, mlrt_hit *hit)
{
    struct mlrt_ray_segment segment;
    uint32_t number = MLRT_NONE;
    if (counters) ++counters->ray_count;
    if (mlrt_get_lone_segment(ray, &segment)) {
        if (counters) ++counters->packet_count;
        number = tree->structure->tracer.trace_ray(tree, &segment, ray->skip, ray->any, NULL, counters);
    }
    mlrt_set_result(tree, ray, number, hit);
}

static const struct mlrt_kernels *kernels_of(const mlrt_tree *tree, const struct mlrt_lone_ray *ray)
{
    return ray->kernels ? ray->kernels : mlrt_widest_kernels(tree->structure);
}

void mlrt_trace_lone_ray(const mlrt_tree *tree, struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    if (MLRT_UNLIKELY(tree->bvh.unit != 1)) {
        if (kernels_of(tree, ray)->trace_ray_in_units(tree, ray, hit) != MLRT_OK) mlrt_trace_by_ray(tree, ray, NULL, hit);
        return;
    }
    switch (
        mlrt_take_lone_ray(&tree->bvh.whole, ray->given_origin, ray->given_direction, ray->t_min, ray->t_max, ray)) {
    case MLRT_LONE_RAY_MAY_HIT:
        (void)kernels_of(tree, ray)->trace_ray(tree, ray, hit);
        break;
    case MLRT_LONE_RAY_NOT_CARRIED:
        mlrt_trace_by_ray(tree, ray, NULL, hit);
        break;
    default:
        mlrt_set_miss(ray->any, hit);
    }
}

/*
 * Rays that are alike are traced together if there are more than FEWEST_ALIKE, others if there are more than
 * FEWEST_OTHERS and the tree has few nodes. Nanoseconds of a call one by one and together (AVX-512, t and triangles):
 * pixels of erw6, 5 rays 704, 720, 8 rays 1090, 626; rays in all directions in erw6, 8 rays 1146, 1150, 12 rays 1570,
 * 1232; among 10,000 triangles in a cube, 12 rays 4183, 4882, 16 rays 5665, 6154.
 */
#define FEWEST_ALIKE  6
#define FEWEST_OTHERS 8
#define FEW_NODES     64

/* Is it faster to trace the rays together? Those that miss the scene are not. *ray is used up. */
static int should_go_together(const struct mlrt_job *job, struct mlrt_lone_ray *ray)
{
    const struct mlrt_source *source = &job->source;
    float room[3];
    if (source->count <= FEWEST_ALIKE) return 0;
    if (!mlrt_are_alike(source) && (source->count <= FEWEST_OTHERS || job->tree->bvh.node_count > FEW_NODES)) {
        return 0;
    }
    mlrt_read_ray(source, 0, room, ray);
    return job->tree->bvh.unit != 1 ||
           mlrt_take_lone_ray(&job->tree->bvh.whole, ray->given_origin, ray->given_direction, ray->t_min, ray->t_max,
                              ray) == MLRT_LONE_RAY_MAY_HIT;
}

int mlrt_trace_few_rays(const struct mlrt_job *job)
{
    mlrt_hit hits[MLRT_PACKET_RAYS];
    struct mlrt_lone_ray ray;
    if (should_go_together(job, &ray)) return 0;
    ray.kernels = job->kernels;
    ray.any = job->any;
    for (uint32_t i = 0; i < job->source.count; ++i) {
        float room[3];
        mlrt_read_ray(&job->source, i, room, &ray);
        mlrt_trace_lone_ray(job->tree, &ray, &hits[i]);
    }
    mlrt_write_hits(hits, 0, job->source.count, &job->frame);
    return 1;
}
