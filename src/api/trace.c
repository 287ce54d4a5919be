/* SPDX-License-Identifier: MIT */
/*
 * The exported functions that trace arrays of rays, pictures and points. Each checks its arguments, resolves its
 * options, and calls one internal function that does the work.
 */
#include "api/arguments.h"
#include "api/options.h"
#include "job/sink.h"
#include "rays/rows.h"
#include "rays/source.h"
#include "run/lone_ray.h"
#include "run/run_job.h"

/* Runs a job for a list of rays, whose source is set. Returns a status. */
static int32_t run_list(const mlrt_tree *tree, const struct mlrt_call *call, const mlrt_hits *hits,
                        struct mlrt_job *job)
{
    const int are_set = call->is_plain && mlrt_set_plain_options(tree, call->options, job);
    int32_t status = are_set ? MLRT_OK : mlrt_resolve_options(tree, call->options, job);
    if (status != MLRT_OK || mlrt_trace_few_rays(job, &call->run, hits)) return status;
    if (are_set) status = mlrt_resolve_options(tree, call->options, job);
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
    status = mlrt_resolve_options(tree, call.options, &job);
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
    if (status == MLRT_OK) status = mlrt_resolve_options(tree, call->options, job);
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
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_POINTS, "points", 0, points, &own_points);
    if (status == MLRT_OK && own_points.count && !own_points.positions.data)
        status = mlrt_fail(MLRT_ERROR_ARGUMENT, "points.positions: NULL, but count is not 0");
    if (status == MLRT_OK) status = mlrt_take_struct(MLRT_STRUCT_LIGHT, "light", 0, light, &own_light);
    if (status == MLRT_OK) status = mlrt_check_fields(MLRT_FORM_BYTES, "occluded", 0, occluded);
    if (status != MLRT_OK) return mlrt_end_call(&call.run.voice, status);
    struct mlrt_job job;
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = *occluded};
    mlrt_make_light_source(tree, &own_points, &own_light, &job.source);
    if (!own_points.row_length) mlrt_set_rows(mlrt_find_row_length(&job.source), &job.source);
    return mlrt_end_call(&call.run.voice, run_list(tree, &call, &hits, &job));
}
