/* SPDX-License-Identifier: MIT */
/* world.c - a room and bodies that move: see world.h */
#include "engine/world.h"

#include "common/furniture.h"
#include "common/steady_math.h"

#include <math.h>
#include <string.h>

enum { BLOB_COLUMNS = 96, BLOB_ROWS = 48, RING_COLUMNS = 128, RING_ROWS = 20 };

static const double centre[3] = {0.6, 1.45, 0.05}; // what turns, turns around this point

void to_body(const struct body *body, const float from[3], int is_point, float to[3])
{
    float v[3];
    for (int k = 0; k < 3; k++) v[k] = from[k] - (is_point ? body->position[k] : 0);
    for (int k = 0; k < 3; k++)
        to[k] = body->rotation[0][k] * v[0] + body->rotation[1][k] * v[1] + body->rotation[2][k] * v[2];
}

void to_world(const struct body *body, const float from[3], int is_point, float to[3])
{
    for (int k = 0; k < 3; k++) {
        const float *row = body->rotation[k];
        to[k] = row[0] * from[0] + row[1] * from[1] + row[2] * from[2] + (is_point ? body->position[k] : 0);
    }
}

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

static void ring_point(const void *surface, double u, double v, double point[3])
{
    const double radius = 0.6 + 0.04 * turn_cos(v);
    (void)surface;
    point[0] = radius * turn_cos(u);
    point[1] = 0.04 * turn_sin(v);
    point[2] = -radius * turn_sin(u);
}

// A ball whose distance from the middle waves; `surface` is the time.
static void blob_point(const void *surface, double u, double v, double point[3])
{
    const double time = *(const double *)surface, y = -turn_cos(v / 2), r = turn_sin(v / 2);
    const double x = r * turn_cos(u), z = -r * turn_sin(u);
    const double size = 0.30 + 0.10 * noise(1.8 * x + 0.9 * time, 1.8 * y, 1.8 * z - 0.6 * time);
    point[0] = size * x;
    point[1] = size * y;
    point[2] = size * z;
}

// Normals of vertices, each the sum of those of the triangles around it: as long as the areas, so that slivers say
// little.
static void set_normals(struct shape *shape)
{
    const struct scene *mesh = &shape->mesh;
    memset(shape->normals, 0, 3 * mesh->vertex_count * sizeof(float));
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->indices + 3 * i;
        const float *a = mesh->vertices + 3 * corner[0], *b = mesh->vertices + 3 * corner[1];
        const float *c = mesh->vertices + 3 * corner[2];
        for (int k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            const float normal = (b[l] - a[l]) * (c[m] - a[m]) - (b[m] - a[m]) * (c[l] - a[l]);
            for (int j = 0; j < 3; j++) shape->normals[3 * corner[j] + (uint32_t)k] += normal;
        }
    }
}

static mlrt_mesh mesh_of(const struct scene *scene, uint32_t id, uint32_t mask)
{
    return (mlrt_mesh){.struct_size = sizeof(mlrt_mesh),
                       .id = id,
                       .vertices = scene->vertices,
                       .vertex_count = scene->vertex_count,
                       .indices = scene->indices,
                       .triangle_count = scene->triangle_count,
                       .mask = mask};
}

// Small trees of things that move: built fastest, by one thread, maybe in a job of the engine.
static int32_t build_shape(const struct world *world, struct shape *shape, uint32_t mask)
{
    const mlrt_mesh mesh = mesh_of(&shape->mesh, 0, mask);
    const mlrt_tree_options options = {.struct_size = sizeof options, .preset = MLRT_TREE_FAST, .host = &world->host};
    mlrt_destroy_tree(shape->tree);
    return mlrt_build_tree(&mesh, 1, &options, &shape->tree);
}

static int32_t make_shape(const struct world *world, struct shape *shape, uint32_t mask)
{
    const size_t size = 3 * shape->mesh.vertex_count * sizeof(float);
    shape->normals = world->host.allocate(world->host.user, size, 16);
    if (!shape->normals) return MLRT_ERROR_OUT_OF_MEMORY;
    set_normals(shape);
    return build_shape(world, shape, mask);
}

/* ---- from frame to frame ----------------------------------------------------------------------------------------- */

int32_t world_deform(struct world *world, double time)
{
    struct shape *blob = &world->shapes[0];
    struct scene made;
    memset(&made, 0, sizeof made);
    struct shapes shapes = {&made, 0, 0, 0, 0};
    const struct place place = world_place();
    add_surface(&shapes, &place, BLOB_COLUMNS, BLOB_ROWS, 1, blob_point, &time);
    const int good = !shapes.failed && made.vertex_count == blob->mesh.vertex_count;
    if (good) memcpy(blob->mesh.vertices, made.vertices, 3 * made.vertex_count * sizeof(float));
    free_scene(&made);
    if (!good) return MLRT_ERROR_OUT_OF_MEMORY;
    set_normals(blob);
    return build_shape(world, blob, SEEN_BY_ALL);
}

// Around the vertical, then around the world's x.
static void set_rotation(struct body *body, double turns, double tilt)
{
    const double c = turn_cos(turns), s = turn_sin(turns), d = turn_cos(tilt), t = turn_sin(tilt);
    const double rotation[3][3] = {{c, 0, s}, {s * t, d, -c * t}, {-s * d, t, c * d}};
    for (int i = 0; i < 9; i++) body->rotation[i / 3][i % 3] = (float)rotation[i / 3][i % 3];
}

static void set_body(struct world *world, int number, const char *name, const struct shape *shape, double radius,
                     double red, double green, double blue)
{
    struct body *body = &world->bodies[number];
    *body = (struct body){.name = name, .shape = shape, .radius = (float)radius};
    body->colour[0] = (float)red, body->colour[1] = (float)green, body->colour[2] = (float)blue;
}

void world_move(struct world *world, double time, uint32_t picked)
{
    set_rotation(&world->bodies[BODY_BLOB], 0.05 * time, 0);
    set_rotation(&world->bodies[BODY_RING], 0.1 * time, 0.06 + 0.11 * time);
    set_rotation(&world->bodies[BODY_RING_2], 0.13 * time, 0.28 + 0.09 * time);
    set_rotation(&world->bodies[BODY_MARKER], 0.5 * time, 0);
    for (int i = 0; i < BODY_COUNT; i++) {
        for (int k = 0; k < 3; k++) world->bodies[i].position[k] = (float)centre[k];
    }
    world->bodies[BODY_MARKER].position[1] += picked == BODY_COUNT ? 100.0f : picked == BODY_BLOB ? 0.5f : 0.7f;
}

int32_t world_begin(struct world *world, const mlrt_host *host)
{
    static const double cone[3][2] = {{0, 0}, {0.07, 0.16}, {0, 0.16}},
                        ball[5][2] = {{0, -0.06}, {0.042, -0.042}, {0.06, 0}, {0.042, 0.042}, {0, 0.06}};
    double start = 0;
    memset(world, 0, sizeof *world);
    world->host = *host;
    struct shapes blob = {&world->shapes[0].mesh, 0, 0, 0, 0}, ring = {&world->shapes[1].mesh, 0, 0, 0, 0};
    struct shapes marker = {&world->shapes[2].mesh, 0, 0, 0, 0}, bulb = {&world->bulb, 0, 0, 0, 0};
    const struct place place = world_place();
    const struct view view = {{3.8, 1.8, 2.2}, {-0.1, 1.22, -0.2}, {0, 1, 0}, 50, {1.5, 2.4, 1.3}};
    if (load_scene("office", &world->room)) return MLRT_ERROR_OUT_OF_MEMORY;
    world->room.view = view;
    const double *light = world->room.view.light;
    const struct place hung = place_at(&place, light[0], light[1], light[2], 0);
    add_lathe(&bulb, &hung, ball, 5, 4, 24);
    add_surface(&blob, &place, BLOB_COLUMNS, BLOB_ROWS, 1, blob_point, &start);
    add_surface(&ring, &place, RING_COLUMNS, RING_ROWS, 1, ring_point, NULL);
    add_lathe(&marker, &place, cone, 3, 1, 24);
    if (blob.failed || ring.failed || marker.failed || bulb.failed) return MLRT_ERROR_OUT_OF_MEMORY;
    int32_t status = make_shape(world, &world->shapes[0], SEEN_BY_ALL);
    if (status == MLRT_OK) status = make_shape(world, &world->shapes[1], SEEN_BY_ALL);
    if (status == MLRT_OK) status = make_shape(world, &world->shapes[2], SEEN_BY_CAMERA);
    set_body(world, BODY_BLOB, "blob", &world->shapes[0], 0.45, 0.10, 0.42, 0.52);
    set_body(world, BODY_RING, "ring", &world->shapes[1], 0.65, 0.75, 0.52, 0.16);
    set_body(world, BODY_RING_2, "ring_2", &world->shapes[1], 0.65, 0.62, 0.64, 0.68);
    set_body(world, BODY_MARKER, "marker", &world->shapes[2], 0.2, 0.35, 0.85, 0.20);
    world_move(world, 0, BODY_COUNT);
    return status;
}

void world_end(struct world *world)
{
    mlrt_destroy_tree(world->tree);
    for (int i = 0; i < 3; i++) {
        struct shape *shape = &world->shapes[i];
        mlrt_destroy_tree(shape->tree);
        if (shape->normals)
            world->host.free(world->host.user, shape->normals, 3 * shape->mesh.vertex_count * sizeof(float), 16);
        free_scene(&shape->mesh);
    }
    free_scene(&world->bulb);
    free_scene(&world->room);
}
