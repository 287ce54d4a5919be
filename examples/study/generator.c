/* SPDX-License-Identifier: MIT */
/* generator.c - the rays that every method traces: see generator.h */
#include "generator.h"

#include "common/must.h"
#include "common/steady_math.h"
#include "common/view.h"
#include "mlrta/kdtree.h"
#include "scene/tree.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SEED = 1 };

struct source {
    const struct subject *subject;
    float lo[3], hi[3]; // of the scene
    uint32_t random;
};

typedef void (*ray_maker)(struct source *source, size_t number, float origin[3], float direction[3]);

static void draw_origin(struct source *source, float origin[3])
{
    for (int k = 0; k < 3; k++) {
        double lo = source->lo[k], hi = source->hi[k];
        origin[k] = (float)random_between(&source->random, 0.75 * lo + 0.25 * hi, 0.25 * lo + 0.75 * hi);
    }
}

static void draw_direction(struct source *source, float direction[3])
{
    double z = random_between(&source->random, -1, 1), turns = random_between(&source->random, 0, 1);
    double radius = sqrt(1 - z * z);
    direction[0] = (float)(radius * turn_cos(turns));
    direction[1] = (float)(radius * turn_sin(turns));
    direction[2] = (float)z;
}

static void draw_triangle(struct source *source, const float *corner[3])
{
    const struct scene *scene = &source->subject->scene;
    const uint32_t *indices =
        scene->indices + 3 * (size_t)random_below(&source->random, (uint32_t)scene->triangle_count);
    uint32_t first = random_below(&source->random, 3);
    for (uint32_t i = 0; i < 3; i++) corner[i] = scene->vertices + 3 * (size_t)indices[(first + i) % 3];
}

static void aim(const float origin[3], const float target[3], float direction[3])
{
    for (int k = 0; k < 3; k++) direction[k] = (float)((double)target[k] - origin[k]);
}

// Towards the point of a random triangle with the weights 1 - u - v, u, v.
static void aim_at_triangle(struct source *source, double u, double v, float origin[3], float direction[3])
{
    const float *corner[3];
    float target[3];
    draw_triangle(source, corner);
    for (int k = 0; k < 3; k++) target[k] = (float)((1 - u - v) * corner[0][k] + u * corner[1][k] + v * corner[2][k]);
    draw_origin(source, origin);
    aim(origin, target, direction);
}

static void make_random(struct source *source, size_t number, float origin[3], float direction[3])
{
    (void)number;
    draw_origin(source, origin);
    draw_direction(source, direction);
}

static void make_surface(struct source *source, size_t number, float origin[3], float direction[3])
{
    (void)number;
    double u = random_between(&source->random, 0, 1), v = random_between(&source->random, 0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    aim_at_triangle(source, u, v, origin, direction);
}

static void make_edge(struct source *source, size_t number, float origin[3], float direction[3])
{
    (void)number;
    aim_at_triangle(source, random_between(&source->random, 0, 1), 0, origin, direction);
}

static void make_vertex(struct source *source, size_t number, float origin[3], float direction[3])
{
    (void)number;
    aim_at_triangle(source, 0, 0, origin, direction);
}

static void make_axis(struct source *source, size_t number, float origin[3], float direction[3])
{
    uint32_t side = random_below(&source->random, 6), axis = side / 2;
    const float *corner[3];
    draw_origin(source, origin);
    draw_triangle(source, corner);
    for (uint32_t k = 0; k < 3; k++) {
        direction[k] = 0;
        if (number % 2 && k != axis) origin[k] = corner[0][k];
    }
    direction[axis] = side % 2 ? 1 : -1;
}

// A tree that is one leaf has no split plane; a vertex's coordinate stands for it.
static void make_split_plane(struct source *source, size_t number, float origin[3], float direction[3])
{
    (void)number;
    const struct mlrt_tree *tree = source->subject->kdtree;
    const float *corner[3];
    draw_triangle(source, corner);
    uint32_t axis = random_below(&source->random, 3);
    float plane = corner[0][axis];
    for (int attempt = 0; attempt < 64; attempt++) {
        const struct mlrt_node *node = &tree->kdtree.nodes[random_below(&source->random, tree->kdtree.node_count)];
        if (mlrt_node_is_leaf(node)) continue;
        axis = mlrt_node_axis(node);
        plane = node->u.split;
        break;
    }
    double turns = random_between(&source->random, 0, 1);
    draw_origin(source, origin);
    origin[axis] = plane;
    direction[axis] = 0;
    direction[(axis + 1) % 3] = (float)turn_cos(turns);
    direction[(axis + 2) % 3] = (float)turn_sin(turns);
}

static const struct {
    const char *name;
    ray_maker make; // NULL: a picture
} generators[GENERATOR_COUNT] = {
    [GENERATE_CAMERA] = {"camera", NULL},
    [GENERATE_RANDOM] = {"random", make_random},
    [GENERATE_SURFACE] = {"surface", make_surface},
    [GENERATE_EDGE] = {"edge", make_edge},
    [GENERATE_VERTEX] = {"vertex", make_vertex},
    [GENERATE_AXIS] = {"axis", make_axis},
    [GENERATE_SPLIT_PLANE] = {"split_plane", make_split_plane},
};

const char *generator_name(enum generator generator)
{
    return generators[generator].name;
}

int allocate_rays(size_t count, struct ray_set *rays)
{
    *rays = (struct ray_set){.count = count};
    rays->origins = malloc(count * sizeof *rays->origins);
    rays->directions = malloc(count * sizeof *rays->directions);
    if (rays->origins && rays->directions) return 0;
    fprintf(stderr, "not enough memory for %zu rays\n", count);
    return 1;
}

float largest_component(const struct ray_set *rays)
{
    float largest = 0;
    for (size_t i = 0; i < rays->count; i++) {
        for (int k = 0; k < 3; k++) {
            largest = fmaxf(largest, fmaxf(fabsf(rays->origins[i][k]), fabsf(rays->directions[i][k])));
        }
    }
    return largest;
}

void free_rays(struct ray_set *rays)
{
    free(rays->origins);
    free(rays->directions);
    *rays = (struct ray_set){.count = 0};
}

// Sides are multiples of 4, so that no packet of 4x4 rays is cut.
static int generate_picture(const struct subject *subject, size_t count, struct ray_set *rays)
{
    uint32_t side = (uint32_t)sqrt((double)count) / 4 * 4;
    if (side == 0) side = 4;
    mlrt_camera camera;
    if (camera_of_view(&subject->scene.view, side, side, &camera)) return 1;
    if (allocate_rays((size_t)side * side, rays)) return 1;
    rays->row_length = side;
    rays->is_picture = 1;
    rays->camera = camera;
    const mlrt_array origins = {rays->origins, 0, 0}, directions = {rays->directions, 0, 0};
    return has_failed(mlrt_camera_rays(&camera, &origins, &directions), "make the camera's rays");
}

int generate_rays(enum generator generator, const struct subject *subject, size_t count, struct ray_set *rays)
{
    struct source source = {.subject = subject, .random = SEED};
    if (!generators[generator].make) return generate_picture(subject, count, rays);
    if (subject->scene.triangle_count == 0) {
        fprintf(stderr, "%s: no triangles to aim at\n", subject->name);
        return 1;
    }
    if (allocate_rays(count, rays)) return 1;
    scene_bounds(&subject->scene, source.lo, source.hi);
    for (size_t i = 0; i < count; i++) generators[generator].make(&source, i, rays->origins[i], rays->directions[i]);
    return 0;
}
