/* SPDX-License-Identifier: MIT */
/* tinybvh.c - tinybvh as a method: its own hierarchy, one ray at a time */
#include "method.h"

#ifdef HAVE_TINYBVH

#include "tinybvh.h"

#include <math.h>

// Its builder ends the program on meshes beyond these sizes, where products of its floats are 0 or infinite. On meshes
// a thousand times as large as the smaller, or as small as the larger, it finds nothing, so they count as misses.
#define SMALLEST_SIZE 1e-15f
#define LARGEST_SIZE  1e16f

static int is_within_range(const struct scene *scene)
{
    float minimum[3], maximum[3], size = 0;
    scene_bounds(scene, minimum, maximum);
    for (int k = 0; k < 3; k++) size = fmaxf(size, maximum[k] - minimum[k]);
    return size >= SMALLEST_SIZE && size <= LARGEST_SIZE;
}

static int create(struct method_run *run)
{
    const struct scene *scene = &run->subject->scene;
    if (!is_within_range(scene)) return 0;
    run->state = tinybvh_create(scene->vertices, scene->vertex_count, scene->indices, scene->triangle_count);
    return 0;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    for (size_t i = 0; i < rays->count && !run->state; i++) answers->triangles[i] = MLRT_NONE;
    if (!run->state) return;
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
