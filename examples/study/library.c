/* SPDX-License-Identifier: MIT */
/*
 * library.c - the library's own methods, through its public interface, with ids as the only results
 *
 * Rays are passed as arrays, as to all other methods, with the row length of a picture as a hint. Two methods get the
 * camera instead: then the library makes the same rays itself, and bounds those of a tile without reading them.
 */
#include "method.h"

#include <stdio.h>
#include <stdlib.h>

static void check(const struct method_run *run, int32_t status)
{
    if (status == MLRT_OK) return;
    fprintf(stderr, "%s: cannot trace: %s\n", run->method->name, mlrt_status_string(status));
    exit(1);
}

static const mlrt_tree *tree_of(const struct method_run *run)
{
    return subject_tree(run->subject, run->method->variant);
}

static void trace_arrays(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    const mlrt_trace_options options = {.struct_size = sizeof options, .method = run->method->variant};
    const mlrt_rays input = {.struct_size = sizeof input,
                             .row_length = rays->row_length,
                             .count = rays->count,
                             .origins = {rays->origins, 0},
                             .directions = {rays->directions, 0}};
    const mlrt_hits output = {
        .struct_size = sizeof output, .triangle = {answers->triangles, 0, 0}, .t = {answers->t, 0, 0}};
    check(run, mlrt_trace_packet(tree_of(run), &input, &options, &output));
}

static void trace_camera(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    const mlrt_trace_options options = {.struct_size = sizeof options, .method = run->method->variant};
    const mlrt_hits output = {
        .struct_size = sizeof output, .triangle = {answers->triangles, 0, 0}, .t = {answers->t, 0, 0}};
    check(run, mlrt_render_tiles(tree_of(run), &rays->camera, &options, &output, NULL, NULL));
}

const struct method library_methods[] = {
    {"mlrt_ray", "mlrt, one ray", 1, 0, MLRT_METHOD_RAY, NULL, trace_arrays, NULL},
    {"mlrt_packet2", "mlrt, 2x2 packets", 1, 0, MLRT_METHOD_PACKET2, NULL, trace_arrays, NULL},
    {"mlrt_packet4", "mlrt, 4x4 packets", 1, 0, MLRT_METHOD_PACKET4, NULL, trace_arrays, NULL},
    {"mlrt_multilevel", "mlrt, multi-level", 1, 0, MLRT_METHOD_MULTILEVEL, NULL, trace_arrays, NULL},
    {"mlrt_camera", "mlrt, multi-level, from the camera", 1, 1, MLRT_METHOD_MULTILEVEL, NULL, trace_camera, NULL},
    {"mlrt_tile", "mlrt, tiles", 1, 0, MLRT_METHOD_TILE, NULL, trace_arrays, NULL},
    {"mlrt_tile_camera", "mlrt, tiles, from the camera", 1, 1, MLRT_METHOD_TILE, NULL, trace_camera, NULL},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
