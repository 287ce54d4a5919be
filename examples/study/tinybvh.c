/* SPDX-License-Identifier: MIT */
/* tinybvh.c - tinybvh as a method: its own hierarchy, one ray at a time */
#include "method.h"

#ifdef HAVE_TINYBVH

#include "tinybvh.h"

#include <stdio.h>

static int create(struct method_run *run)
{
    const struct scene *scene = &run->subject->scene;
    run->state = tinybvh_create(scene->vertices, scene->vertex_count, scene->indices, scene->triangle_count);
    if (!run->state) fprintf(stderr, "%s: cannot build a hierarchy of %s\n", run->method->name, run->subject->name);
    return !run->state;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    tinybvh_trace(run->state, (const float(*)[3])rays->origins, (const float(*)[3])rays->directions, rays->count,
                  MLRT_NONE, answers->triangles, answers->t);
}

static void destroy(struct method_run *run)
{
    if (run->state) tinybvh_destroy(run->state);
}

const struct method tinybvh_methods[] = {
    {"tinybvh", "tinybvh 1.6, one ray", 0, 0, 0, create, trace, destroy},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};

#else

const struct method tinybvh_methods[] = {{NULL, NULL, 0, 0, 0, NULL, NULL, NULL}};

#endif
