/* SPDX-License-Identifier: MIT */
/* library.c - the library's own methods, through its public interface, with ids as the only results */
#include "method.h"

#include <stdio.h>
#include <stdlib.h>

static void trace(const struct method_run *run, const struct ray_set *rays, uint32_t *triangles)
{
    const mlrt_trace_options options = {.struct_size = sizeof options, .method = run->method->variant};
    const mlrt_rays input = {.struct_size = sizeof input,
                             .row_length = rays->row_length,
                             .count = rays->count,
                             .origins = {rays->origins, 0},
                             .directions = {rays->directions, 0}};
    const mlrt_hits output = {.struct_size = sizeof output, .triangle = {triangles, 0, 0}};
    int32_t status = mlrt_trace_packet(run->subject->tree, &input, &options, &output);
    if (status == MLRT_OK) return;
    fprintf(stderr, "%s: cannot trace: %s\n", run->method->name, mlrt_status_string(status));
    exit(1);
}

const struct method library_methods[] = {
    {"mlrt_ray", "mlrt, one ray", 1, MLRT_METHOD_RAY, NULL, trace, NULL},
    {"mlrt_packet2", "mlrt, 2x2 packets", 1, MLRT_METHOD_PACKET2, NULL, trace, NULL},
    {"mlrt_packet4", "mlrt, 4x4 packets", 1, MLRT_METHOD_PACKET4, NULL, trace, NULL},
    {"mlrt_multilevel", "mlrt, multi-level", 1, MLRT_METHOD_MULTILEVEL, NULL, trace, NULL},
    {NULL, NULL, 0, 0, NULL, NULL, NULL},
};
