/* SPDX-License-Identifier: MIT */
/* library.c - tasks done by the library: see contest.h */
#include "contest.h"

static int32_t render_frame(const mlrt_tree *tree, const mlrt_trace_options *options, const struct task *task,
                            const struct answers *answers)
{
    struct shade_job job = {.camera = &task->subject->camera,
                            .normals = task->subject->normals,
                            .triangle_count = (uint32_t)task->subject->scene.triangle_count,
                            .rgba = answers->rgba};
    mlrt_trace_options with_outputs = *options;
    with_outputs.outputs = MLRT_OUTPUT_TRIANGLE;
    return mlrt_render_tiles(tree, job.camera, &with_outputs, NULL, shade_tile_of_ids, &job);
}

static int32_t trace_primary(const mlrt_tree *tree, const mlrt_trace_options *options, const struct task *task,
                             const struct answers *answers)
{
    const mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {answers->triangles, 0, 0}};
    return mlrt_render_tiles(tree, &task->subject->camera, options, &frame, NULL, NULL);
}

static int32_t trace_shadows(const mlrt_tree *tree, const mlrt_trace_options *options, const struct task *task,
                             const struct answers *answers)
{
    const float *p = task->kind == SUN ? task->sun : task->subject->light;
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = task->subject->camera.width,
                                .count = task->element_count,
                                .positions = {task->origins, 0},
                                .skip = {task->skip, 0}};
    const mlrt_light light = {.struct_size = sizeof light,
                              .kind = task->kind == SUN ? MLRT_LIGHT_DIRECTIONAL : MLRT_LIGHT_POINT,
                              .position = {p[0], p[1], p[2]}};
    const mlrt_array occluded = {answers->occluded, 0, 0};
    return mlrt_occluded_points(tree, &points, &light, options, &occluded);
}

static int32_t trace_arrays(const mlrt_tree *tree, const mlrt_trace_options *options, const struct task *task,
                            const struct answers *answers)
{
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = task->kind == LIST || task->kind == BOUNCE ? 0 : task->subject->camera.width,
                            .count = task->element_count,
                            .origins = {task->origins, 0},
                            .directions = {task->directions, 0}};
    const mlrt_hits hits = {
        .struct_size = sizeof hits, .t = {answers->t, 0, 0}, .triangle = {answers->triangles, 0, 0}};
    return mlrt_trace_packet(tree, &rays, options, &hits);
}

int32_t run_library(const mlrt_tree *tree, const mlrt_trace_options *options, const struct task *task,
                    const struct answers *answers)
{
    switch (task->kind) {
    case FRAME:
        return render_frame(tree, options, task, answers);
    case PRIMARY:
        return trace_primary(tree, options, task, answers);
    case SHADOW:
    case SUN:
        return trace_shadows(tree, options, task, answers);
    default:
        return trace_arrays(tree, options, task, answers);
    }
}
