/* SPDX-License-Identifier: MIT */
/* guess.c - the library without exactness as a method: see guess.h */
#include "guess.h"

#include "method.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

static struct {
    int32_t (*build_tree)(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                          mlrt_tree **tree);
    void (*destroy_tree)(mlrt_tree *tree);
    int32_t (*trace_packet)(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                            const mlrt_hits *hits);
    int32_t (*render_tiles)(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                            const mlrt_hits *frame, mlrt_tile_callback callback, void *user);
} guess;

// A cast from void * to a function pointer is POSIX's, not C's: copying the bits says the same.
static int find_function(void *handle, const char *name, void *function)
{
    void *symbol = dlsym(handle, name);
    if (!symbol) fprintf(stderr, "%s\n", dlerror());
    memcpy(function, &symbol, sizeof symbol);
    return !symbol;
}

int load_guess(const char *path)
{
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL); // until the program ends
    if (!handle) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    return find_function(handle, "mlrt_build_tree", &guess.build_tree) |
           find_function(handle, "mlrt_destroy_tree", &guess.destroy_tree) |
           find_function(handle, "mlrt_trace_packet", &guess.trace_packet) |
           find_function(handle, "mlrt_render_tiles", &guess.render_tiles);
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
