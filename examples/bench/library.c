/* SPDX-License-Identifier: MIT */
/* library.c - tasks done by a build of the library: see library.h */
#include "library.h"

#include <stddef.h>
#include <string.h>

/* ---- tasks --------------------------------------------------------------------------------------------------- */

struct copy_job {
    const struct answers *answers;
    uint32_t pitch;
};

static int32_t render_frame(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                            const struct task *task, const struct answers *answers)
{
    struct shade_job job = {.camera = &task->subject->camera,
                            .normals = task->subject->normals,
                            .triangle_count = (uint32_t)task->subject->scene.triangle_count,
                            .rgba = answers->rgba};
    mlrt_trace_options with_outputs = *options;
    with_outputs.outputs = MLRT_OUTPUT_TRIANGLE;
    return library->render_tiles(tree, job.camera, &with_outputs, NULL, shade_tile_of_ids, &job);
}

// For MLRT_OUTPUT_TRIANGLE and MLRT_OUTPUT_OCCLUDED: what a lit tile would be shaded by.
static int32_t copy_tile(void *user, const mlrt_tile *tile)
{
    const struct copy_job *job = user;
    for (uint32_t j = 0; j < tile->height; j++) {
        const size_t from = (size_t)j * tile->width, to = (size_t)(tile->y + j) * job->pitch + tile->x;
        memcpy(job->answers->triangles + to, tile->triangle + from, tile->width * sizeof *tile->triangle);
        memcpy(job->answers->occluded + to, tile->occluded + from, tile->width);
    }
    return 0;
}

// The shaded picture, or without one what it would be shaded by: asked for in the same way.
static int32_t render_lit_frame(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                                const struct task *task, const struct answers *answers)
{
    const mlrt_light light = light_of(task->subject);
    struct shade_job job = {.camera = &task->subject->camera,
                            .normals = task->subject->normals,
                            .triangle_count = (uint32_t)task->subject->scene.triangle_count,
                            .rgba = answers->rgba};
    struct copy_job copy = {answers, job.camera->width};
    mlrt_trace_options with_light = *options;
    with_light.lights = &light;
    with_light.light_count = 1;
    with_light.outputs = MLRT_OUTPUT_TRIANGLE | MLRT_OUTPUT_OCCLUDED;
    if (!job.rgba) return library->render_tiles(tree, job.camera, &with_light, NULL, copy_tile, &copy);
    return library->render_tiles(tree, job.camera, &with_light, NULL, shade_lit_tile, &job);
}

static int32_t trace_primary(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                             const struct task *task, const struct answers *answers)
{
    const mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {answers->triangles, 0, 0}};
    return library->render_tiles(tree, &task->subject->camera, options, &frame, NULL, NULL);
}

static int32_t trace_shadows(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                             const struct task *task, const struct answers *answers)
{
    const float *p = task->kind == SUN ? task->sun : task->subject->light;
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = task->row_length,
                                .count = task->element_count,
                                .positions = {task->origins, 0},
                                .skip = {task->skip, 0}};
    const mlrt_light light = {.struct_size = sizeof light,
                              .kind = task->kind == SUN ? MLRT_LIGHT_DIRECTIONAL : MLRT_LIGHT_POINT,
                              .position = {p[0], p[1], p[2]}};
    const mlrt_array occluded = {answers->occluded, 0, 0};
    return library->occluded_points(tree, &points, &light, options, &occluded);
}

// Rays of hemispheres share their origins, unless an old library does not know how.
static mlrt_rays rays_of(const struct task *task, int shares_origins)
{
    mlrt_rays rays = {.struct_size = sizeof rays, .row_length = task->row_length, .count = task->element_count};
    const struct ray_record *first = task->records;
    if (first) {
        rays.origins = (mlrt_const_array){first->origin, sizeof *first};
        rays.directions = (mlrt_const_array){first->direction, sizeof *first};
        rays.t_min = (mlrt_const_array){&first->t_min, sizeof *first};
        rays.t_max = (mlrt_const_array){&first->t_max, sizeof *first};
    } else {
        rays.origins = (mlrt_const_array){task->origins, 0};
        rays.directions = (mlrt_const_array){task->directions, 0};
        rays.t_max = (mlrt_const_array){task->t_max, 0};
    }
    if (shares_origins) {
        rays.origins.data = task->shared_origins;
        rays.rays_per_origin = HEMISPHERE_RAYS;
    } else {
        rays.struct_size = offsetof(mlrt_rays, rays_per_origin);
    }
    return rays;
}

static int32_t trace_arrays(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                            const struct task *task, const struct answers *answers)
{
    mlrt_rays rays = rays_of(task, task->shared_origins != NULL);
    const mlrt_hits hits = {.struct_size = sizeof hits,
                            .t = {answers->t, 0, 0},
                            .u = {answers->u, 0, 0},
                            .v = {answers->v, 0, 0},
                            .mesh = {answers->mesh, 0, 0},
                            .triangle = {answers->triangles, 0, 0},
                            .occluded = {answers->occluded, 0, 0}};
    mlrt_trace_options with_query = *options;
    if (is_any(task->kind)) with_query.query = MLRT_QUERY_ANY;
    int32_t status = library->trace_packet(tree, &rays, &with_query, &hits);
    if (status == MLRT_ERROR_STRUCT_SIZE && task->shared_origins) {
        rays = rays_of(task, 0);
        status = library->trace_packet(tree, &rays, &with_query, &hits);
    }
    return status;
}

// A call for each ray, as a program makes that has a ray at a time.
static int32_t trace_singles(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                             const struct task *task, const struct answers *answers)
{
    mlrt_trace_options with_query = *options;
    mlrt_ray ray = {.struct_size = sizeof ray};
    mlrt_hit hit = {.struct_size = sizeof hit};
    if (is_any(task->kind)) with_query.query = MLRT_QUERY_ANY;
    for (size_t i = 0; i < task->element_count; i++) {
        const struct ray_record *record = &task->records[i];
        if (isnan(record->origin[0])) {
            if (answers->triangles) answers->triangles[i] = MLRT_NONE, answers->t[i] = INFINITY;
            if (answers->occluded) answers->occluded[i] = 0;
            continue;
        }
        memcpy(ray.origin, record->origin, sizeof ray.origin);
        memcpy(ray.direction, record->direction, sizeof ray.direction);
        ray.t_min = record->t_min;
        ray.t_max = record->t_max;
        const int32_t status = library->trace_ray(tree, &ray, &with_query, &hit);
        if (status != MLRT_OK) return status;
        if (answers->triangles) answers->triangles[i] = hit.triangle, answers->t[i] = hit.t;
        if (answers->occluded) answers->occluded[i] = (uint8_t)hit.occluded;
    }
    return MLRT_OK;
}

int32_t run_library(const struct library *library, const mlrt_tree *tree, const mlrt_trace_options *options,
                    const struct task *task, const struct answers *answers)
{
    switch (task->kind) {
    case FRAME:
        return render_frame(library, tree, options, task, answers);
    case LIT:
        return render_lit_frame(library, tree, options, task, answers);
    case PRIMARY:
        return trace_primary(library, tree, options, task, answers);
    case SHADOW:
    case SUN:
        return trace_shadows(library, tree, options, task, answers);
    case SINGLE:
    case SINGLE_ANY:
        return trace_singles(library, tree, options, task, answers);
    default:
        return trace_arrays(library, tree, options, task, answers);
    }
}
