/* SPDX-License-Identifier: MIT */
/*
 * The exported functions that trace. Each checks its arguments, resolves its options in the floating-point environment
 * of the library, and calls one internal function that does the work.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "api/arguments.h"
#include "base/counters.h"
#include "base/host.h"
#include "exact/nearest.h"
#include "exact/offset.h"
#include "hits/shadow_ray.h"
#include "job/structure.h"
#include "job/write_arrays.h"
#include "rays/rows.h"
#include "run/all_hits.h"
#include "run/dispatch.h"
#include "run/lone_ray.h"
#include "run/run_job.h"

/* Sides of tiles, in pixels. */
#define RAY_TILE             32 /* method ray: a render stops sooner with small tiles */
#define DEFAULT_MINIMUM_TILE 32
#define DEFAULT_SPLIT_FACTOR 16

static int is_power_of_two(uint32_t n)
{
    return n != 0 && (n & (n - 1)) == 0;
}

/* Sets *size to `given`, or to `standard` if that is 0. A power of two from 4 to `most` is right. Returns a status. */
static int32_t resolve_size(const char *field, uint32_t given, uint32_t standard, uint32_t most, uint32_t *size)
{
    *size = given ? given : standard;
    if (given == 0 || (is_power_of_two(given) && given >= 4 && given <= most)) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "options.%s: %lu is not a power of two from 4 to %lu", field,
                     (unsigned long)given, (unsigned long)most);
}

/* Sets *method to `given` with the default resolved. Returns a status: it must be one of the tree's structure. */
static int32_t resolve_method(int32_t given, const struct mlrt_tree *tree, int32_t *method)
{
    const struct mlrt_structure *structure = tree->structure, *other = &mlrt_structure_kdtree;
    *method = given ? given : structure->tracer.method;
    if (structure->tracer.methods >> *method & 1) return MLRT_OK;
    if (structure == other) other = &mlrt_structure_bvh;
    return mlrt_fail(MLRT_ERROR_UNSUPPORTED, "options.method: %ld is for %s, and the tree is %s", (long)given,
                     other->plural, structure->name);
}

/* Sets a job's kernels to those of an instruction set. Returns a status. */
static int32_t choose_kernels(int32_t isa, int counting, struct mlrt_job *job)
{
    job->kernels = mlrt_select_kernels(job->tree->structure, isa, job->method, counting);
    if (job->kernels) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_UNSUPPORTED, "options.isa: %ld is not in this build, or not on this machine",
                     (long)isa);
}

/* The default side of the tiles that threads claim. */
static uint32_t standard_initial_tile(const struct mlrt_job *job)
{
    const struct mlrt_structure *structure = job->tree->structure;
    if (job->method == MLRT_METHOD_RAY) return RAY_TILE;
    if (job->source.kind == MLRT_SOURCE_CAMERA) return structure->tracer.camera_side;
    return job->source.width <= 4 ? structure->tracer.list_side : structure->tracer.row_side;
}

/*
 * Checks the options, and sets the fields of a job that follow from them and the tree. The job's source is set
 * already.
 */
static int32_t resolve_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    int32_t status = mlrt_check_options(options);
    if (status == MLRT_OK) status = resolve_method(options->method, tree, &job->method);
    if (status != MLRT_OK) return status;
    job->tree = tree;
    job->any = options->query == MLRT_QUERY_ANY;
    job->multilevel.culling = options->culling;
    job->multilevel.culling_check = options->culling_check != 0;
    job->multilevel.shortcuts = ~options->shortcuts_off;
    status = resolve_size("initial_tile_size", options->initial_tile_size, standard_initial_tile(job), 1024,
                          &job->initial_tile_size);
    if (status != MLRT_OK) return status;
    const uint32_t initial = job->initial_tile_size;
    status = resolve_size("minimum_tile_size", options->minimum_tile_size,
                          initial < DEFAULT_MINIMUM_TILE ? initial : DEFAULT_MINIMUM_TILE, initial,
                          &job->multilevel.minimum_tile_size);
    if (status != MLRT_OK) return status;
    const uint32_t split_factor = options->split_factor ? options->split_factor : DEFAULT_SPLIT_FACTOR;
    job->multilevel.split_divisor = split_factor == 4 ? 2 : 4;
    job->outputs = options->outputs;
    mlrt_set_masks(tree, options->mask, tree->structure->tracer.filters_leaves, &job->source);
    return choose_kernels(options->isa, options->counters != NULL, job);
}

/* All words of a part of a struct, or-ed together. `size` is a multiple of 4. */
MLRT_INLINE uint64_t words_of(const void *part, size_t size)
{
    uint64_t all = 0, two;
    uint32_t one;
    MLRT_UNROLL
    for (size_t i = 0; i + sizeof two <= size; i += sizeof two) {
        memcpy(&two, (const unsigned char *)part + i, sizeof two);
        all |= two;
    }
    if (size % sizeof two) {
        memcpy(&one, (const unsigned char *)part + size - sizeof one, sizeof one);
        all |= one;
    }
    return all;
}

/* Are all options 0, except for the query, the instruction set, the mask and the pool? */
MLRT_INLINE int are_plain(const mlrt_trace_options *of)
{
    const size_t first = offsetof(mlrt_trace_options, culling), last = offsetof(mlrt_trace_options, counters);
    return ((uint32_t)of->method | (of->query & ~MLRT_QUERY_ANY) |
            words_of(&of->culling, offsetof(mlrt_trace_options, mask) - first) |
            words_of(&of->counters, sizeof *of - last)) == 0;
}

/* ---- few rays ---- */

/*
 * A call of this many rays, or fewer, traces them one by one, and needs no job. Of rays of one point, 4 so take 0.75 of
 * the time of a job and 8 take 1.24 of it; of rays that have nothing in common, 4 take 0.78 and 8 take 0.87 (AVX-512,
 * 10,000 triangles in a cube).
 */
#define FEW_RAYS 4

/* Has the array elements of `size` bytes that can be read, or written, one by one? Others are checked by a job. */
static int is_simple(const void *data, size_t stride, size_t size)
{
    const size_t unit = size < 4 ? size : 4;
    return (uintptr_t)data % unit == 0 &&
           (stride == 0 || (stride >= size && stride % unit == 0 && stride <= MLRT_STRIDE_LIMIT));
}

static int are_simple_rays(const mlrt_rays *rays)
{
    if (rays->struct_size != sizeof *rays || rays->count - 1 >= FEW_RAYS || rays->row_length) return 0;
    if (rays->rays_per_origin || rays->reserved || rays->skip.data || rays->mask.data) return 0;
    return rays->origins.data && rays->directions.data && is_simple(rays->origins.data, rays->origins.stride, 12) &&
           is_simple(rays->directions.data, rays->directions.stride, 12) &&
           is_simple(rays->t_min.data, rays->t_min.stride, 4) && is_simple(rays->t_max.data, rays->t_max.stride, 4);
}

static int is_simple_result(const mlrt_array *array, size_t size)
{
    return !array->data || (!array->row_stride && is_simple(array->data, array->stride, size));
}

/* Are all arrays of results simple, and none but those that the query writes? */
static int are_simple_hits(const mlrt_hits *hits, int any)
{
    if (hits->struct_size != sizeof *hits || hits->reserved) return 0;
    if (!any) {
        const int has_results =
            hits->t.data || hits->u.data || hits->v.data || hits->mesh.data || hits->triangle.data || hits->facing.data;
        return has_results && !hits->occluded.data && is_simple_result(&hits->t, 4) && is_simple_result(&hits->u, 4) &&
               is_simple_result(&hits->v, 4) && is_simple_result(&hits->mesh, 4) &&
               is_simple_result(&hits->triangle, 4) && is_simple_result(&hits->facing, 4);
    }
    return hits->occluded.data && !hits->t.data && !hits->u.data && !hits->v.data && !hits->mesh.data &&
           !hits->triangle.data && !hits->facing.data && is_simple_result(&hits->occluded, 1);
}

MLRT_INLINE void take_element(const mlrt_const_array *array, size_t i, size_t size, void *element)
{
    if (!array->data) return;
    memcpy(element, (const unsigned char *)array->data + i * (array->stride ? array->stride : size), size);
}

/* Writes a field of all hits to its array. `field` is that of the first. */
static void give_field(const mlrt_hit *hits, size_t count, const void *field, const mlrt_array *array)
{
    const size_t stride = array->stride ? array->stride : 4;
    for (size_t i = 0; i < count && array->data; ++i) {
        memcpy((unsigned char *)array->data + i * stride, (const unsigned char *)field + i * sizeof *hits, 4);
    }
}

/* Traces few rays one by one. All are read before a result is written, since arrays may overlap. */
static MLRT_NOINLINE void trace_few_rays(const mlrt_tree *tree, const mlrt_rays *rays, struct mlrt_lone_ray *lone,
                                         const mlrt_hits *results)
{
    mlrt_hit hits[FEW_RAYS];
    for (size_t i = 0; i < rays->count; ++i) {
        mlrt_ray ray = {.t_max = INFINITY};
        take_element(&rays->origins, i, sizeof ray.origin, ray.origin);
        take_element(&rays->directions, i, sizeof ray.direction, ray.direction);
        take_element(&rays->t_min, i, sizeof ray.t_min, &ray.t_min);
        take_element(&rays->t_max, i, sizeof ray.t_max, &ray.t_max);
        if (ray.t_max == 0) ray.t_max = -1; /* 0 is a limit in an array, and none in mlrt_ray */
        (void)mlrt_trace_lone_ray(tree, &ray, lone, &hits[i]);
    }
    if (lone->any) {
        const size_t stride = results->occluded.stride ? results->occluded.stride : 1;
        uint8_t *occluded = results->occluded.data;
        for (size_t i = 0; i < rays->count && occluded; ++i) occluded[i * stride] = (uint8_t)hits[i].occluded;
        return;
    }
    give_field(hits, rays->count, &hits->t, &results->t);
    give_field(hits, rays->count, &hits->u, &results->u);
    give_field(hits, rays->count, &hits->v, &results->v);
    give_field(hits, rays->count, &hits->mesh, &results->mesh);
    give_field(hits, rays->count, &hits->triangle, &results->triangle);
    give_field(hits, rays->count, &hits->facing, &results->facing);
}

/* Sets *lone from options that are plain. Returns 0 for others. */
MLRT_INLINE int take_plain_options(const mlrt_trace_options *options, struct mlrt_lone_ray *lone)
{
    *lone = (struct mlrt_lone_ray){.kernels = NULL, .mask = MLRT_MASK_ALL, .skip = MLRT_NONE, .any = 0};
    if (!options) return 1;
    if (options->struct_size != sizeof *options || !are_plain(options) || options->isa) return 0;
    lone->any = options->query;
    if (options->mask) lone->mask = options->mask;
    return 1;
}

/* ---- rays ---- */

static MLRT_NOINLINE int32_t make_packet_job(const mlrt_tree *tree, const mlrt_rays *rays, const struct mlrt_call *call,
                                             const mlrt_hits *hits, struct mlrt_job *job)
{
    mlrt_make_ray_source(tree, rays, &job->source);
    if (!rays->row_length) mlrt_set_rows(mlrt_find_row_length(&job->source), &job->source);
    mlrt_make_sink(hits, job->source.width, 1, &job->frame);
    return resolve_options(tree, &call->options, job);
}

MLRT_API int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   const mlrt_hits *hits)
{
    if (!tree || !rays || !hits) return mlrt_fail_null("tree rays hits", !tree + 2 * !rays);
    struct mlrt_lone_ray lone;
    if (tree->structure->tracer.has_lone_kernels && are_simple_rays(rays) && take_plain_options(options, &lone) &&
        are_simple_hits(hits, lone.any)) {
        const uint64_t environment = mlrt_enter_fp_environment();
        trace_few_rays(tree, rays, &lone, hits);
        mlrt_leave_fp_environment(environment);
        return MLRT_OK;
    }
    mlrt_rays own_rays;
    mlrt_hits own_hits;
    struct mlrt_call call;
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_take_rays(rays, &own_rays);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_HITS, "hits", 0, hits, &own_hits);
    if (status == MLRT_OK) {
        status = mlrt_check_hits("hits", &own_hits, &call.options, 0, !own_rays.count || call.run.counters);
    }
    if (status != MLRT_OK) return mlrt_end_traced(&call, status);
    struct mlrt_job job = {.callback = NULL};
    const uint64_t environment = mlrt_enter_fp_environment();
    status = make_packet_job(tree, &own_rays, &call, &own_hits, &job);
    mlrt_leave_fp_environment(environment);
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_run_job(&job, &call.run));
    return mlrt_end_traced(&call, status);
}

static MLRT_NOINLINE float resolve_t_max(const mlrt_ray *ray)
{
    return ray->t_max == 0 ? INFINITY : ray->t_max;
}

/* Traces one ray, by a method other than ray, as a list of one. The arrays of the list are the fields of `hit`. */
static int32_t trace_as_list(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options, int any,
                             mlrt_hit *hit)
{
    const uint64_t environment = mlrt_enter_fp_environment(); /* the caller's may take a denormal t_max for 0 */
    const float t_max = resolve_t_max(ray);
    mlrt_leave_fp_environment(environment);
    const uint32_t skip[2] = {ray->skip_mesh, ray->skip_triangle};
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = 1,
                            .origins = {ray->origin, 0},
                            .directions = {ray->direction, 0},
                            .t_min = {&ray->t_min, 0},
                            .t_max = {&t_max, 0},
                            .skip = {ray->flags & MLRT_RAY_SKIP ? skip : NULL, 0}};
    uint8_t occluded = 0;
    mlrt_hits hits = {.struct_size = sizeof hits};
    if (any) {
        hits.occluded.data = &occluded;
    } else {
        hits.t.data = &hit->t;
        hits.u.data = &hit->u;
        hits.v.data = &hit->v;
        hits.mesh.data = &hit->mesh;
        hits.triangle.data = &hit->triangle;
        hits.facing.data = &hit->facing;
    }
    mlrt_trace_options alone = *options;
    alone.host = NULL;
    const int32_t status = mlrt_trace_packet(tree, &rays, &alone, &hits);
    if (status == MLRT_OK) hit->occluded = any ? occluded : hit->triangle != MLRT_NONE;
    return status;
}

/* Traces one ray with all checks of a call. */
static MLRT_NOINLINE int32_t trace_as_call(const mlrt_tree *tree, const mlrt_ray *ray,
                                           const mlrt_trace_options *options, struct mlrt_lone_ray *lone, mlrt_hit *hit)
{
    struct mlrt_call call;
    struct mlrt_job job = {.callback = NULL};
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = resolve_options(tree, &call.options, &job);
    if (status != MLRT_OK) return status;
    if (call.options.method != MLRT_METHOD_DEFAULT && call.options.method != MLRT_METHOD_RAY) {
        return trace_as_list(tree, ray, &call.options, job.any, hit);
    }
    mlrt_counters own = {.struct_size = 0};
    mlrt_counters *counters = call.options.counters;
    const uint64_t environment = mlrt_enter_fp_environment();
    if (job.kernels->trace_ray) {
        lone->kernels = job.kernels;
        (void)mlrt_trace_lone_ray(tree, ray, lone, hit);
    } else {
        mlrt_trace_by_ray(tree, ray, lone->any, lone->mask, lone->skip, counters ? &own : NULL, hit);
    }
    mlrt_leave_fp_environment(environment);
    if (counters) mlrt_add_counters(counters, &own);
    return MLRT_OK;
}

/* As mlrt_trace_ray, for structs of other versions. Fields of the hit that the query does not set keep their values. */
static MLRT_NOINLINE int32_t trace_versioned_ray(const mlrt_tree *tree, const mlrt_ray *ray,
                                                 const mlrt_trace_options *options, mlrt_hit *hit)
{
    mlrt_ray own_ray;
    mlrt_hit own_hit;
    mlrt_trace_options own_options;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_RAY, "ray", 0, ray, &own_ray);
    if (status == MLRT_OK) status = mlrt_check_result_size(MLRT_STRUCT_HIT, "hit", hit);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_TRACE_OPTIONS, "options", 0, options, &own_options);
    if (status != MLRT_OK) return status;
    memcpy(&own_hit, hit, mlrt_forms[MLRT_STRUCT_HIT].first_size);
    own_hit.struct_size = sizeof own_hit;
    status = mlrt_trace_ray(tree, &own_ray, options ? &own_options : NULL, &own_hit);
    if (status == MLRT_OK) mlrt_give_struct(&own_hit, sizeof own_hit, hit);
    return status;
}

MLRT_API int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit)
{
    struct mlrt_lone_ray lone;
    if (MLRT_UNLIKELY(!tree || !ray || !hit)) return mlrt_fail_null("tree ray hit", !tree + 2 * !ray);
    if (MLRT_UNLIKELY(ray->struct_size != sizeof *ray || hit->struct_size != sizeof *hit)) {
        return trace_versioned_ray(tree, ray, options, hit);
    }
    lone.kernels = NULL;
    lone.any = 0;
    lone.mask = MLRT_MASK_ALL;
    lone.skip = MLRT_NONE;
    if (MLRT_UNLIKELY(ray->flags)) {
        if (ray->flags != MLRT_RAY_SKIP) return mlrt_check_fields(MLRT_STRUCT_RAY, "ray", 0, ray);
        lone.skip = mlrt_triangle_number(tree, ray->skip_mesh, ray->skip_triangle);
    }
    if (options) {
        if (MLRT_UNLIKELY(options->struct_size != sizeof *options)) return trace_versioned_ray(tree, ray, options, hit);
        lone.any = options->query;
        if (options->mask) lone.mask = options->mask;
        if (MLRT_UNLIKELY(!are_plain(options))) return trace_as_call(tree, ray, options, &lone, hit);
        if (options->isa) {
            lone.kernels = (uint32_t)options->isa <= MLRT_ISA_AVX512
                               ? mlrt_select_kernels(tree->structure, options->isa, MLRT_METHOD_DEFAULT, 0)
                               : NULL;
            if (!lone.kernels || !lone.kernels->trace_ray) return trace_as_call(tree, ray, options, &lone, hit);
        }
    }
    if (MLRT_UNLIKELY(!tree->structure->tracer.has_lone_kernels)) return trace_as_call(tree, ray, options, &lone, hit);
    const uint64_t environment = mlrt_enter_fp_environment();
    if (mlrt_trace_lone_ray(tree, ray, &lone, hit)) {
        mlrt_leave_after_inexact(environment);
    } else {
        mlrt_leave_fp_environment(environment);
    }
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t make_list_job(const mlrt_tree *tree, const mlrt_rays *rays, const struct mlrt_call *call,
                                           struct mlrt_job *job)
{
    mlrt_make_ray_source(tree, rays, &job->source);
    return resolve_options(tree, &call->options, job);
}

MLRT_API int32_t mlrt_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                     const mlrt_hit_lists *lists)
{
    if (!tree || !rays || !lists) return mlrt_fail_null("tree rays lists", !tree + 2 * !rays);
    mlrt_rays own_rays;
    mlrt_hit_lists own_lists;
    struct mlrt_call call;
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_take_rays(rays, &own_rays);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_HIT_LISTS, "lists", 0, lists, &own_lists);
    if (status == MLRT_OK) status = mlrt_check_lists(&own_lists, !own_rays.count || call.run.counters);
    if (status != MLRT_OK) return mlrt_end_traced(&call, status);
    struct mlrt_job job = {.callback = NULL};
    const uint64_t environment = mlrt_enter_fp_environment();
    status = make_list_job(tree, &own_rays, &call, &job);
    mlrt_leave_fp_environment(environment);
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_run_all_hits(tree, &job.source, &own_lists, &call.run));
    return mlrt_end_traced(&call, status);
}

/* Makes a job for each light: as that of the picture, but for any hit, and without results of its own. */
static int32_t make_light_jobs(const mlrt_light *lights, uint32_t count, const struct mlrt_job *job,
                               struct mlrt_job jobs[MLRT_LIGHT_LIMIT])
{
    for (uint32_t i = 0; i < count; ++i) {
        mlrt_light light;
        const void *given = (const unsigned char *)lights + (size_t)i * lights->struct_size;
        /* Checked first: with another size, the light might reach beyond the array. */
        int32_t status = mlrt_check_equal_sizes("options.lights[%lu]", i, lights, given);
        if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_LIGHT, "options.lights[%lu]", i, given, &light);
        if (status != MLRT_OK) return status;
        jobs[i] = *job;
        jobs[i].any = 1;
        jobs[i].callback = NULL;
        jobs[i].light_count = 0;
        mlrt_set_light(&light, &jobs[i].source);
    }
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t make_render_job(const mlrt_tree *tree, const mlrt_camera *camera,
                                             const struct mlrt_call *call, const mlrt_hits *frame, struct mlrt_job *job,
                                             struct mlrt_job light_jobs[MLRT_LIGHT_LIMIT])
{
    mlrt_trace_options options = call->options;
    const mlrt_light *lights;
    uint32_t light_count;
    int32_t status = mlrt_make_view_source(camera, &job->source);
    if (status == MLRT_OK) status = mlrt_take_lights(&options, &lights, &light_count);
    if (status == MLRT_OK) status = resolve_options(tree, &options, job);
    if (status == MLRT_OK) status = make_light_jobs(lights, light_count, job, light_jobs);
    if (status != MLRT_OK) return status;
    mlrt_make_sink(frame, job->source.width, 0, &job->frame);
    if (light_count && (job->frame.channel[MLRT_CHANNEL_OCCLUDED].data || job->outputs & MLRT_OUTPUT_OCCLUDED)) {
        job->lights = light_jobs;
        job->light_count = light_count;
        job->multilevel.shortcuts &= ~(uint32_t)MLRT_SHORTCUT_WHOLE_TILES;
    }
    return status;
}

MLRT_API int32_t mlrt_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                                   const mlrt_hits *frame, mlrt_tile_callback callback, void *user)
{
    if (!tree || !camera) return mlrt_fail_null("tree camera", !tree);
    mlrt_camera own_camera;
    mlrt_hits own_frame;
    struct mlrt_call call;
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_CAMERA, "camera", 0, camera, &own_camera);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_FORM_FRAME, "frame", 0, frame, &own_frame);
    if (status == MLRT_OK) {
        status = mlrt_check_hits("frame", &own_frame, &call.options, call.options.light_count != 0,
                                 callback || call.run.counters);
    }
    if (status != MLRT_OK) return mlrt_end_traced(&call, status);
    struct mlrt_job job = {.callback = callback, .user = user}, light_jobs[MLRT_LIGHT_LIMIT];
    const uint64_t environment = mlrt_enter_fp_environment();
    status = make_render_job(tree, &own_camera, &call, &own_frame, &job, light_jobs);
    mlrt_leave_fp_environment(environment);
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_run_job(&job, &call.run));
    return mlrt_end_traced(&call, status);
}

static float *vector_at(const mlrt_array *array, uint32_t width, uint32_t i, uint32_t j)
{
    const size_t stride = array->stride ? array->stride : 12;
    const size_t row_stride = array->row_stride ? array->row_stride : width * stride;
    return (float *)(void *)((unsigned char *)array->data + j * row_stride + i * stride);
}

static MLRT_NOINLINE int32_t write_camera_rays(const mlrt_camera *camera, const mlrt_array *origins,
                                               const mlrt_array *directions)
{
    struct mlrt_view view;
    const int32_t status = mlrt_make_view(camera, &view);
    if (status != MLRT_OK) return status;
    for (uint32_t j = 0; j < view.height; ++j) {
        for (uint32_t i = 0; i < view.width; ++i) {
            float p[3];
            mlrt_view_point(&view, i, j, p);
            if (origins->data) {
                memcpy(vector_at(origins, view.width, i, j), view.parallel ? p : view.eye, sizeof p);
            }
            if (directions->data) {
                memcpy(vector_at(directions, view.width, i, j), view.parallel ? camera->direction : p, sizeof p);
            }
        }
    }
    return MLRT_OK;
}

MLRT_API int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions)
{
    static const mlrt_array none;
    const mlrt_array *const vectors[2] = {origins ? origins : &none, directions ? directions : &none};
    mlrt_camera own;
    if (!camera) return mlrt_fail_null("camera", 0);
    int32_t status = mlrt_take_struct(MLRT_STRUCT_CAMERA, "camera", 0, camera, &own);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_VECTORS, "origins", 0, vectors[0]);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_VECTORS, "directions", 0, vectors[1]);
    if (status != MLRT_OK) return status;
    const uint64_t environment = mlrt_enter_fp_environment();
    status = write_camera_rays(&own, vectors[0], vectors[1]);
    mlrt_leave_fp_environment(environment);
    return status;
}

static MLRT_NOINLINE int32_t make_light_job(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                            const struct mlrt_call *call, const mlrt_array *occluded,
                                            struct mlrt_job *job)
{
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = *occluded};
    mlrt_make_light_source(tree, points, light, &job->source);
    mlrt_make_sink(&hits, job->source.width, 1, &job->frame);
    return resolve_options(tree, &call->options, job);
}

MLRT_API int32_t mlrt_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                      const mlrt_trace_options *options, const mlrt_array *occluded)
{
    if (!tree || !points || !light || !occluded || !occluded->data) {
        return mlrt_fail_null("tree points light occluded occluded.data",
                              !tree + 2 * !points + 4 * !light + 8 * !occluded);
    }
    mlrt_points own_points;
    mlrt_light own_light;
    struct mlrt_call call;
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_take_points(points, &own_points);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_LIGHT, "light", 0, light, &own_light);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_BYTES, "occluded", 0, occluded);
    if (status != MLRT_OK) return mlrt_end_traced(&call, status);
    call.options.query = MLRT_QUERY_ANY;
    struct mlrt_job job = {.callback = NULL};
    const uint64_t environment = mlrt_enter_fp_environment();
    status = make_light_job(tree, &own_points, &own_light, &call, occluded, &job);
    mlrt_leave_fp_environment(environment);
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_run_job(&job, &call.run));
    return mlrt_end_traced(&call, status);
}

/* Sets *number to that of a triangle in the tree. Returns a status: there must be one. */
static int32_t find_triangle(const mlrt_tree *tree, const char *path, uint32_t mesh, uint32_t triangle,
                             uint32_t *number)
{
    *number = mlrt_triangle_number(tree, mesh, triangle);
    if (*number != MLRT_NONE) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "%s: there is no triangle %lu in a mesh with id %lu", path,
                     (unsigned long)triangle, (unsigned long)mesh);
}

/* Sets the shadow ray from the hit of a ray to a light, and whether the light is on the ray's side of the surface. */
static MLRT_NOINLINE int32_t set_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, uint32_t number,
                                            const mlrt_light *light, mlrt_ray *shadow, int32_t *faces)
{
    struct mlrt_source source;
    struct mlrt_ray_segment segment, answer;
    int is_on_side = 0;
    mlrt_set_light(light, &source);
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    if (!mlrt_make_segment(ray->origin, ray->direction, ray->t_min, resolve_t_max(ray), &segment) ||
        !mlrt_triangle_is_finite(&triangle) || !mlrt_hits_triangle(&segment, &triangle, NULL)) {
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "hit.triangle: the ray does not hit triangle %lu of mesh %lu",
                         (unsigned long)shadow->skip_triangle, (unsigned long)shadow->skip_mesh);
    }
    if (mlrt_make_shadow_ray(&source, &triangle, &segment, &is_on_side, &answer)) {
        memcpy(shadow->origin, answer.origin, sizeof shadow->origin);
        memcpy(shadow->direction, answer.direction, sizeof shadow->direction);
        shadow->t_max = isinf(answer.t_max) ? 0 : answer.t_max;
    }
    *faces = is_on_side;
    return MLRT_OK;
}

MLRT_API int32_t mlrt_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit,
                                 const mlrt_light *light, mlrt_ray *shadow, int32_t *faces)
{
    if (!tree || !ray || !hit || !light || !shadow || !faces) {
        return mlrt_fail_null("tree ray hit light shadow faces",
                              !tree + 2 * !ray + 4 * !hit + 8 * !light + 16 * !shadow);
    }
    mlrt_ray own_ray;
    mlrt_hit own_hit;
    mlrt_light own_light;
    uint32_t number;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_RAY, "ray", 0, ray, &own_ray);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_HIT, "hit", 0, hit, &own_hit);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_LIGHT, "light", 0, light, &own_light);
    if (status == MLRT_OK) status = mlrt_check_result_size(MLRT_STRUCT_RAY, "shadow", shadow);
    if (status == MLRT_OK) status = find_triangle(tree, "hit.triangle", own_hit.mesh, own_hit.triangle, &number);
    if (status != MLRT_OK) return status;
    mlrt_ray answer = {.struct_size = sizeof answer,
                       .flags = MLRT_RAY_SKIP,
                       .skip_mesh = own_hit.mesh,
                       .skip_triangle = own_hit.triangle};
    const uint64_t environment = mlrt_enter_fp_environment();
    status = set_shadow_ray(tree, &own_ray, number, &own_light, &answer, faces);
    mlrt_leave_fp_environment(environment);
    if (status != MLRT_OK) return status;
    mlrt_give_struct(&answer, sizeof answer, shadow);
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t find_offset_point(const struct mlrt_triangle *triangle, float u, float v, int32_t side,
                                               float point[3])
{
    if (mlrt_find_offset_point(triangle, u, v, side, point)) return MLRT_OK;
    if (mlrt_triangle_is_finite(triangle) && mlrt_triangle_has_area(triangle)) {
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "point: it would leave the range of float");
    }
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "triangle: it is not finite, or has no area");
}

MLRT_API int32_t mlrt_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float point[3])
{
    if (!tree || !point) return mlrt_fail_null("tree point", !tree);
    if (side != 1 && side != -1) return mlrt_fail(MLRT_ERROR_ARGUMENT, "side: %ld is not 1 or -1", (long)side);
    uint32_t number;
    int32_t status = find_triangle(tree, "triangle", mesh, triangle, &number);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_FLOAT, "u", 0, &u);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_FLOAT, "v", 0, &v);
    if (status != MLRT_OK) return status;
    const uint64_t environment = mlrt_enter_fp_environment();
    const struct mlrt_triangle given = mlrt_triangle_at(&tree->by_number, number);
    status = find_offset_point(&given, u, v, side, point);
    mlrt_leave_fp_environment(environment);
    return status;
}
