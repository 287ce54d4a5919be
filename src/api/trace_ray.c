/* SPDX-License-Identifier: MIT */
/*
 * mlrt_trace_ray: one ray a call. A usual call does nothing that its ray does not need; calls with other arguments have
 * functions of their own.
 */
#include <string.h>

#include "api/arguments.h"
#include "api/options.h"
#include "job/structure.h"
#include "rays/meet_scene.h"
#include "rays/source.h"
#include "run/dispatch.h"
#include "run/lone_ray.h"
#include "scene/triangle_numbers.h"

/* Sets what of a ray follows from options, which were checked; NULL = defaults. */
MLRT_INLINE void set_lone_ray(const mlrt_ray *ray, const mlrt_trace_options *options, struct mlrt_lone_ray *lone)
{
    lone->given.origin = ray->origin;
    lone->given.direction = ray->direction;
    lone->any = options ? options->query : 0;
    lone->mask = options && options->mask ? options->mask : MLRT_MASK_ALL;
}

/* Traces one ray, whose limits and `skip` are set, with all checks of a call. */
static MLRT_NOINLINE int32_t trace_as_call(const mlrt_tree *tree, const mlrt_ray *ray,
                                           const mlrt_trace_options *options, struct mlrt_lone_ray *lone, mlrt_hit *hit)
{
    const mlrt_rays list = {.struct_size = sizeof list, .count = 1}; /* options are checked as those of a list of one */
    struct mlrt_call call;
    struct mlrt_job job;
    mlrt_make_ray_source(tree, &list, &job.source);
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_resolve_options(tree, call.options, &job);
    if (status != MLRT_OK) return status;
    mlrt_counters own = {.struct_size = 0}, *counters = call.run.counters;
    set_lone_ray(ray, call.options, lone);
    lone->kernels = job.kernels;
    if (job.method == MLRT_METHOD_TILE && !counters)
        MLRT_COMPUTE(mlrt_trace_lone_ray(tree, lone, hit));
    else
        MLRT_COMPUTE(mlrt_trace_by_ray(tree, lone, counters ? &own : NULL, hit));
    if (counters) mlrt_add_counters(counters, &own);
    return MLRT_OK;
}

/*
 * As mlrt_trace_ray, for a ray or a hit of another version. Fields of the hit that the query does not set keep their
 * values.
 */
static MLRT_NOINLINE int32_t trace_versioned_ray(const mlrt_tree *tree, const mlrt_ray *ray,
                                                 const mlrt_trace_options *options, mlrt_hit *hit)
{
    mlrt_ray own_ray;
    mlrt_hit own_hit;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_RAY, "ray", 0, ray, &own_ray);
    if (status == MLRT_OK) status = mlrt_check_result_size(MLRT_STRUCT_HIT, "hit", hit);
    if (status != MLRT_OK) return status;
    memcpy(&own_hit, hit, mlrt_forms[MLRT_STRUCT_HIT].first_size);
    own_hit.struct_size = sizeof own_hit;
    status = mlrt_trace_ray(tree, &own_ray, options, &own_hit);
    if (status == MLRT_OK) mlrt_give_struct(&own_hit, sizeof own_hit, hit);
    return status;
}

/* The number of the triangle that a ray passes through, or MLRT_NONE. */
MLRT_INLINE uint32_t skipped_triangle(const mlrt_tree *tree, const mlrt_ray *ray)
{
    return ray->flags ? mlrt_triangle_number(tree, ray->skip_mesh, ray->skip_triangle) : MLRT_NONE;
}

/* As mlrt_trace_ray, for any arguments. */
static MLRT_NOINLINE int32_t trace_any_ray(const mlrt_tree *tree, const mlrt_ray *ray,
                                           const mlrt_trace_options *options, mlrt_hit *hit)
{
    struct mlrt_lone_ray lone;
    if (!tree || !ray || !hit) return mlrt_fail_null("tree ray hit", !tree + 2 * !ray);
    if (ray->struct_size != sizeof *ray || hit->struct_size != sizeof *hit)
        return trace_versioned_ray(tree, ray, options, hit);
    if (ray->flags & ~(uint32_t)MLRT_RAY_SKIP) return mlrt_check_fields(MLRT_STRUCT_RAY, "ray", 0, ray);
    lone.skip = skipped_triangle(tree, ray);
    lone.t_min = ray->t_min;
    lone.t_max = mlrt_resolve_t_max(ray);
    const int is_plain = tree->structure->tracer.method == MLRT_METHOD_TILE && mlrt_are_plain(options);
    lone.kernels =
        is_plain ? mlrt_select_kernels(tree->structure, options ? options->isa : MLRT_ISA_AUTO, MLRT_METHOD_TILE, 0)
                 : NULL;
    if (!lone.kernels) return trace_as_call(tree, ray, options, &lone, hit);
    set_lone_ray(ray, options, &lone);
    MLRT_COMPUTE(mlrt_trace_lone_ray(tree, &lone, hit));
    return MLRT_OK;
}

/* Traces a ray that skips a triangle. */
static MLRT_NOINLINE int32_t trace_skipping_ray(const mlrt_tree *tree, const mlrt_ray *ray,
                                                const struct mlrt_kernels *kernels, struct mlrt_lone_ray *lone,
                                                mlrt_hit *hit)
{
    lone->skip = skipped_triangle(tree, ray);
    return kernels->trace_ray(tree, lone, hit);
}

/* Is this a call as most programs make it, for one ray through boxes? A kd-tree has a unit of 0. */
MLRT_INLINE int is_usual_call(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                              const mlrt_hit *hit)
{
    static const float none = 0; /* compared as bits, which takes fewer steps */
    return tree && memcmp(&tree->bvh.unit, &none, sizeof none) && ray && ray->struct_size == sizeof *ray && hit &&
           hit->struct_size == sizeof *hit && ray->flags <= MLRT_RAY_SKIP && mlrt_are_plain(options) &&
           (!options || mlrt_is_known_isa(options->isa));
}

/* Traces usual calls where the caller's floating-point environment is as wanted; trace_any_ray traces the others. */
MLRT_API int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit)
{
    struct mlrt_lone_ray lone;
    mlrt_fp_environment environment;
    int32_t status = MLRT_OK;
    if (MLRT_UNLIKELY(!is_usual_call(tree, ray, options, hit) || !mlrt_has_usual_fp_environment(&environment)))
        return trace_any_ray(tree, ray, options, hit);
    const enum mlrt_lone_ray_kind kind =
        mlrt_prepare_lone_ray(&tree->bvh, ray->origin, ray->direction, ray->t_min, mlrt_resolve_t_max(ray), &lone);
    if (kind == MLRT_LONE_RAY_NOT_CARRIED) return trace_any_ray(tree, ray, options, hit);
    if (kind == MLRT_LONE_RAY_MISSES) {
        mlrt_set_miss(options ? options->query : 0, hit);
    } else {
        const int32_t isa = options ? options->isa : MLRT_ISA_AUTO;
        const struct mlrt_kernels *kernels = mlrt_known_kernels(tree->structure, isa);
        if (MLRT_UNLIKELY(!kernels)) return trace_any_ray(tree, ray, options, hit);
        set_lone_ray(ray, options, &lone);
        lone.skip = MLRT_NONE;
        status = ray->flags ? trace_skipping_ray(tree, ray, kernels, &lone, hit) : kernels->trace_ray(tree, &lone, hit);
    }
    return status;
}
