/* SPDX-License-Identifier: MIT */
/* guess.c - the library without exactness as a method: see guess.h */
#include "guess.h"

#include "common/loaded_library.h"
#include "method.h"

#include <stdio.h>

static struct library guess; // until the program ends

int load_guess(const char *path)
{
    return load_library(path, &guess);
}

static int create(struct method_run *run)
{
    const struct scene *scene = &run->subject->scene;
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    mlrt_tree *tree = NULL;
    if (!guess.build_tree) {
        fprintf(stderr, "%s: needs --guess FILE, the library as make GUESS=1 builds it\n", run->method->name);
        return 1;
    }
    const int32_t status = guess.build_tree(&mesh, 1, NULL, &tree);
    if (status != MLRT_OK) fprintf(stderr, "%s: no tree: %s\n", run->method->name, mlrt_status_string(status));
    run->state = tree;
    return status != MLRT_OK;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    const mlrt_rays input = {.struct_size = sizeof input,
                             .row_length = rays->row_length,
                             .count = rays->count,
                             .origins = {rays->origins, 0},
                             .directions = {rays->directions, 0}};
    const mlrt_hits output = {
        .struct_size = sizeof output, .triangle = {answers->triangles, 0, 0}, .t = {answers->t, 0, 0}};
    const int32_t status = run->method->needs_camera
                               ? guess.render_tiles(run->state, &rays->camera, NULL, &output, NULL, NULL)
                               : guess.trace_packet(run->state, &input, NULL, &output);
    if (status != MLRT_OK) fprintf(stderr, "%s: cannot trace: %s\n", run->method->name, mlrt_status_string(status));
}

static void destroy(struct method_run *run)
{
    if (run->state) guess.destroy_tree(run->state);
}

const struct method guess_methods[] = {
    {"guess_tile", "mlrt without exactness, tiles", 0, 0, 0, create, trace, destroy},
    {"guess_tile_camera", "mlrt without exactness, tiles, from the camera", 0, 1, 0, create, trace, destroy},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
