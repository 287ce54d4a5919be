/* SPDX-License-Identifier: MIT */
/* Rays one by one: see lone_ray.h. */
#include "run/lone_ray.h"

#include "base/host.h"
#include "job/job.h"
#include "job/set_hit.h"
#include "job/structure.h"
#include "rays/meet_scene.h"
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

/* As mlrt_prepare_lone_ray, for a ray whose numbers are set as given. */
MLRT_INLINE enum mlrt_lone_ray_kind prepare_ray(const mlrt_tree *tree, struct mlrt_lone_ray *ray)
{
    return mlrt_prepare_lone_ray(&tree->bvh, ray->given.origin, ray->given.direction, ray->t_min, ray->t_max, ray);
}

/* Traces a ray that is prepared. */
MLRT_INLINE void trace_prepared_ray(const mlrt_tree *tree, enum mlrt_lone_ray_kind kind,
                                    const struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    if (kind == MLRT_LONE_RAY_MISSES) {
        mlrt_set_miss(ray->any, hit);
    } else if (kind == MLRT_LONE_RAY_NOT_CARRIED) {
        mlrt_trace_by_ray(tree, ray, NULL, hit);
    } else {
        ray->kernels->trace_ray(tree, ray, hit);
    }
}

void mlrt_trace_lone_ray(const mlrt_tree *tree, struct mlrt_lone_ray *ray, mlrt_hit *hit)
{
    trace_prepared_ray(tree, prepare_ray(tree, ray), ray, hit);
}

/*
 * Rays that are alike are traced together if there are more than MOST_ALIKE, others if there are more than MOST_OTHERS
 * and the tree has few nodes; the wider a vector, the sooner (docs/tried.md, "Looked at once").
 */
#define MOST_ALIKE(width)  (7 + 16 / (width))
#define MOST_OTHERS(width) (12 + 16 / (width))
#define FEW_NODES          64

/* Are the directions of rays, of which there is one at least, less than 45 degrees from the first one? */
static int are_alike(const struct mlrt_source *source)
{
    if (source->kind != MLRT_SOURCE_RAYS) return 1;
    const float *a = mlrt_element(&source->arrays.directions, 0);
    const float size = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    for (uint32_t i = 1; i < source->count; ++i) {
        const float *b = mlrt_element(&source->arrays.directions, i);
        const float dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if (!(dot > 0 && 2 * dot * dot > size * (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]))) return 0;
    }
    return 1;
}

/* Is it faster to trace the rays together, if they meet the scene? */
static int should_go_together(const struct mlrt_job *job)
{
    const uint32_t count = job->source.count, width = job->kernels->width;
    if (count <= MOST_ALIKE(width)) return 0;
    return (count > MOST_OTHERS(width) && job->tree->bvh.node_count <= FEW_NODES) || are_alike(&job->source);
}

/* As mlrt_trace_few_rays, where no worker is needed. */
static MLRT_NOINLINE int trace_few_rays(const struct mlrt_job *job, const mlrt_hits *list)
{
    mlrt_hit hits[MLRT_PACKET_RAYS];
    struct mlrt_lone_ray ray;
    ray.kernels = job->kernels;
    ray.any = job->any;
    mlrt_begin_rays(&job->source, &ray);
    for (uint32_t i = 0; i < job->source.count; ++i) {
        float room[3];
        mlrt_read_ray(&job->source, i, room, &ray);
        const enum mlrt_lone_ray_kind kind = prepare_ray(job->tree, &ray);
        if (i == 0 && kind == MLRT_LONE_RAY_MAY_HIT && should_go_together(job)) return 0;
        trace_prepared_ray(job->tree, kind, &ray, &hits[i]);
    }
    mlrt_write_hits(hits, 0, job->source.count, list);
    return 1;
}

int mlrt_trace_few_rays(const struct mlrt_job *job, const struct mlrt_run_options *options, const mlrt_hits *list)
{
    int is_done;
    if (!mlrt_is_block(job) || !job->source.count || job->method != MLRT_METHOD_TILE || options->counters ||
        options->voice.host.progress)
        return 0;
    MLRT_COMPUTE(is_done = trace_few_rays(job, list));
    return is_done;
}
