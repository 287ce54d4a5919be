/* SPDX-License-Identifier: MIT */
/*
 * The exported functions that trace. Each checks its arguments, resolves its options in the floating-point environment
 * of the library, and calls one internal function that does the work.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "api/arguments.h"
#include "base/host.h"
#include "exact/nearest.h"
#include "exact/offset.h"
#include "hits/shadow_ray.h"
#include "job/structure.h"
#include "job/write_arrays.h"
#include "rays/meet_scene.h"
#include "rays/rows.h"
#include "run/dispatch.h"
#include "run/lone_ray.h"
#include "run/run_job.h"

/* Sides of tiles, in pixels. */
#define RAY_TILE             32 /* method ray: a render stops sooner with small tiles */
#define DEFAULT_MINIMUM_TILE 32
#define DEFAULT_SPLIT_FACTOR 16

/* Sets *size to `given`, or to `standard` if that is 0. A power of two from 4 to `most` is right. Returns a status. */
MLRT_INLINE int32_t resolve_size(const char *field, uint32_t given, uint32_t standard, uint32_t most, uint32_t *size)
{
    *size = given ? given : standard;
    if (MLRT_LIKELY(given == 0) || (!(given & (given - 1)) && given >= 4 && given <= most)) return MLRT_OK;
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

/* Sets the tree, the query and the masks of a job, whose source is set. Of rays to a light, any hit will do. */
MLRT_INLINE void set_query(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    job->tree = tree;
    job->any = options->query == MLRT_QUERY_ANY || mlrt_is_light(&job->source);
    mlrt_set_masks(tree, options->mask, &job->source);
}

/*
 * Checks the options, and sets the fields of a job, whose source is set, that follow from them and the tree, those of a
 * call without lights and callback.
 */
static int32_t resolve_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    int32_t status = mlrt_check_options(options, job->source.kind == MLRT_SOURCE_CAMERA);
    if (status == MLRT_OK) status = resolve_method(options->method, tree, &job->method);
    if (status != MLRT_OK) return status;
    job->lights = NULL;
    job->light_count = 0;
    job->callback.function = NULL;
    set_query(tree, options, job);
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
    job->callback.outputs = options->outputs;
    return choose_kernels(options->isa, options->counters != NULL, job);
}

/* ---- rays ---- */

/* Sets the fields of a job that few rays need, of plain options. Returns 0 if the kernels are not known at once. */
static int set_plain_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    const struct mlrt_structure *structure = tree->structure;
    set_query(tree, options, job);
    job->method = structure->tracer.method;
    job->kernels = mlrt_is_known_isa(options->isa) ? mlrt_known_kernels(structure, options->isa) : NULL;
    return job->kernels != NULL;
}

/* Runs a job for a list of rays, whose source is set. Returns a status. */
static int32_t run_list(const mlrt_tree *tree, const struct mlrt_call *call, const mlrt_hits *hits,
                        struct mlrt_job *job)
{
    const int are_set = call->is_plain && set_plain_options(tree, call->options, job);
    int32_t status = are_set ? MLRT_OK : resolve_options(tree, call->options, job);
    if (status != MLRT_OK || mlrt_trace_few_rays(job, &call->run, hits)) return status;
    if (are_set) status = resolve_options(tree, call->options, job);
    if (status != MLRT_OK) return status;
    mlrt_make_sink(hits, job->source.width, 1, &job->frame);
    return mlrt_note_status(mlrt_run_job(job, &call->run));
}

MLRT_API int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   const mlrt_hits *hits)
{
    if (!tree || !rays || !hits) return mlrt_fail_null("tree rays hits", !tree + 2 * !rays);
    mlrt_rays own_rays;
    mlrt_hits own_hits;
    struct mlrt_call call;
    struct mlrt_job job;
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_take_rays(&rays, &own_rays);
    if (status == MLRT_OK) status = mlrt_take_hits(&hits, &own_hits);
    if (status == MLRT_OK) status = mlrt_check_hits("hits", hits, call.options, 0, !rays->count || call.run.counters);
    if (status != MLRT_OK) return mlrt_end_call(&call.run.voice, status);
    mlrt_make_ray_source(tree, rays, &job.source);
    if (!rays->row_length && rays->count > MLRT_PACKET_RAYS)
        mlrt_set_rows(mlrt_find_row_length(&job.source), &job.source);
    return mlrt_end_call(&call.run.voice, run_list(tree, &call, hits, &job));
}

/* The t_max of a ray. Its bits are looked at, as the caller's floating-point environment may take a denormal for 0. */
static float resolve_t_max(const mlrt_ray *ray)
{
    uint32_t bits;
    memcpy(&bits, &ray->t_max, sizeof bits);
    return bits & 0x7FFFFFFF ? ray->t_max : INFINITY;
}

/* Sets what of a ray follows from options, which were checked; NULL = defaults. */
MLRT_INLINE void set_lone_ray(const mlrt_ray *ray, const mlrt_trace_options *options, struct mlrt_lone_ray *lone)
{
    lone->given_origin = ray->origin;
    lone->given_direction = ray->direction;
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
    if (status == MLRT_OK) status = resolve_options(tree, call.options, &job);
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
    lone.t_max = resolve_t_max(ray);
    const int is_plain = tree->structure->tracer.method == MLRT_METHOD_TILE && mlrt_are_plain(options);
    lone.kernels =
        is_plain ? mlrt_select_kernels(tree->structure, options ? options->isa : MLRT_ISA_AUTO, MLRT_METHOD_TILE, 0)
                 : NULL;
    if (!lone.kernels) return trace_as_call(tree, ray, options, &lone, hit);
    set_lone_ray(ray, options, &lone);
    MLRT_COMPUTE(mlrt_trace_lone_ray(tree, &lone, hit));
    return MLRT_OK;
}

/* Ends a call that turns out not to be a usual one. */
static MLRT_NOINLINE int32_t trace_after_all(const mlrt_tree *tree, const mlrt_ray *ray,
                                             const mlrt_trace_options *options, const mlrt_fp_environment *environment,
                                             mlrt_hit *hit)
{
    mlrt_leave_fp_environment(environment); /* comparisons may have raised flags */
    return trace_any_ray(tree, ray, options, hit);
}

/* Traces a ray that skips a triangle. */
static MLRT_NOINLINE int32_t trace_skipping_ray(const mlrt_tree *tree, const mlrt_ray *ray,
                                                const struct mlrt_kernels *kernels, struct mlrt_lone_ray *lone,
                                                mlrt_hit *hit)
{
    lone->skip = skipped_triangle(tree, ray);
    return kernels->trace_ray(tree, lone, hit);
}

/* Is this a call as most programs make it, for one ray through boxes whose unit is 1? A kd-tree has a unit of 0. */
MLRT_INLINE int is_usual_call(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                              const mlrt_hit *hit)
{
    static const float one = 1; /* compared as bits, which takes fewer steps */
    return tree && !memcmp(&tree->bvh.unit, &one, sizeof one) && ray && ray->struct_size == sizeof *ray && hit &&
           hit->struct_size == sizeof *hit && ray->flags <= MLRT_RAY_SKIP && mlrt_are_plain(options) &&
           (!options || mlrt_is_known_isa(options->isa));
}

/* Traces usual calls in the floating-point environment of the library; trace_any_ray traces the others. */
MLRT_API int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit)
{
    struct mlrt_lone_ray lone;
    mlrt_fp_environment environment;
    int32_t status = MLRT_OK;
    if (MLRT_UNLIKELY(!is_usual_call(tree, ray, options, hit) || !mlrt_has_usual_fp_environment(&environment)))
        return trace_any_ray(tree, ray, options, hit);
    const enum mlrt_lone_ray_kind kind =
        mlrt_take_lone_ray(&tree->bvh.whole, ray->origin, ray->direction, ray->t_min, resolve_t_max(ray), &lone);
    if (kind == MLRT_LONE_RAY_NOT_CARRIED) return trace_after_all(tree, ray, options, &environment, hit);
    if (kind == MLRT_LONE_RAY_MISSES) {
        mlrt_set_miss(options ? options->query : 0, hit);
    } else {
        const int32_t isa = options ? options->isa : MLRT_ISA_AUTO;
        const struct mlrt_kernels *kernels = mlrt_known_kernels(tree->structure, isa);
        if (MLRT_UNLIKELY(!kernels)) return trace_after_all(tree, ray, options, &environment, hit);
        set_lone_ray(ray, options, &lone);
        lone.skip = MLRT_NONE;
        status = ray->flags ? trace_skipping_ray(tree, ray, kernels, &lone, hit) : kernels->trace_ray(tree, &lone, hit);
    }
    mlrt_leave_fp_environment(&environment);
    return status;
}

MLRT_API int32_t mlrt_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                     const mlrt_hit_lists *lists)
{
    if (!tree || !rays || !lists) return mlrt_fail_null("tree rays lists", !tree + 2 * !rays);
    mlrt_rays own_rays;
    mlrt_hit_lists own_lists;
    struct mlrt_call call;
    int32_t status = mlrt_take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_take_rays(&rays, &own_rays);
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_HIT_LISTS, "lists", 0, lists, &own_lists);
    if (status == MLRT_OK) status = mlrt_check_lists(&own_lists, !rays->count || call.run.counters);
    if (status != MLRT_OK) return mlrt_end_call(&call.run.voice, status);
    struct mlrt_job job;
    mlrt_make_ray_source(tree, rays, &job.source);
    status = resolve_options(tree, call.options, &job);
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_run_all_hits(tree, &job.source, &own_lists, &call.run));
    return mlrt_end_call(&call.run.voice, status);
}

/* Makes a job for each light: as that of the picture, but for any hit, and without results of its own. */
static int32_t make_light_jobs(const mlrt_trace_options *options, const struct mlrt_job *job,
                               struct mlrt_job jobs[MLRT_LIGHT_LIMIT])
{
    for (uint32_t i = 0; i < options->light_count; ++i) {
        mlrt_light light;
        const int32_t status = mlrt_take_struct(MLRT_STRUCT_LIGHT, "options.lights[%lu]", i, options->lights, &light);
        if (status != MLRT_OK) return status;
        jobs[i] = *job;
        jobs[i].any = 1;
        mlrt_set_light(&light, &jobs[i].source);
    }
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t make_render_job(const mlrt_tree *tree, const mlrt_camera *camera,
                                             const struct mlrt_call *call, const mlrt_hits *frame, struct mlrt_job *job,
                                             struct mlrt_job light_jobs[MLRT_LIGHT_LIMIT])
{
    const uint32_t light_count = call->options->light_count;
    int32_t status = mlrt_make_view_source(camera, &job->source);
    if (status == MLRT_OK) status = resolve_options(tree, call->options, job);
    if (status == MLRT_OK) status = make_light_jobs(call->options, job, light_jobs);
    if (status != MLRT_OK) return status;
    mlrt_make_sink(frame, job->source.width, 0, &job->frame);
    if (light_count &&
        (job->frame.channel[MLRT_CHANNEL_OCCLUDED].data || job->callback.outputs & MLRT_OUTPUT_OCCLUDED)) {
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
        status = mlrt_check_hits("frame", &own_frame, call.options, call.options->light_count != 0,
                                 callback || call.run.counters);
    }
    if (status != MLRT_OK) return mlrt_end_call(&call.run.voice, status);
    struct mlrt_job job, light_jobs[MLRT_LIGHT_LIMIT];
    MLRT_COMPUTE(status = make_render_job(tree, &own_camera, &call, &own_frame, &job, light_jobs));
    job.callback.function = callback;
    job.callback.user = user;
    if (status == MLRT_OK) status = mlrt_note_status(mlrt_run_job(&job, &call.run));
    return mlrt_end_call(&call.run.voice, status);
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
    mlrt_camera view;
    const int32_t status = mlrt_make_view(camera, &view);
    if (status != MLRT_OK) return status;
    for (uint32_t j = 0; j < view.crop_height; ++j) {
        for (uint32_t i = 0; i < view.crop_width; ++i) {
            float p[3];
            mlrt_view_point(&view, i, j, p);
            if (origins->data)
                memcpy(vector_at(origins, view.crop_width, i, j), mlrt_is_parallel(&view) ? p : view.eye, sizeof p);
            if (directions->data)
                memcpy(vector_at(directions, view.crop_width, i, j), mlrt_is_parallel(&view) ? camera->direction : p,
                       sizeof p);
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
    MLRT_COMPUTE(status = write_camera_rays(&own, vectors[0], vectors[1]));
    return status;
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
    if (status != MLRT_OK) return mlrt_end_call(&call.run.voice, status);
    struct mlrt_job job;
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = *occluded};
    mlrt_make_light_source(tree, &own_points, &own_light, &job.source);
    return mlrt_end_call(&call.run.voice, run_list(tree, &call, &hits, &job));
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
    MLRT_COMPUTE(status = set_shadow_ray(tree, &own_ray, number, &own_light, &answer, faces));
    if (status != MLRT_OK) return status;
    mlrt_give_struct(&answer, sizeof answer, shadow);
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t find_offset_point(const mlrt_tree *tree, uint32_t number, float u, float v, int32_t side,
                                               float point[3])
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    if (mlrt_find_offset_point(&triangle, u, v, side, NULL, point)) return MLRT_OK;
    if (mlrt_triangle_is_finite(&triangle) && mlrt_triangle_has_area(&triangle))
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "point: it would leave the range of float");
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
    MLRT_COMPUTE(status = find_offset_point(tree, number, u, v, side, point));
    return status;
}
