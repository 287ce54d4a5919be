/* SPDX-License-Identifier: MIT */
/* draw.c - tiles of the picture, and picking: see draw.h */
#include "engine/draw.h"

#include <math.h>
#include <string.h>

enum { PIXEL_COUNT = TILE_SIZE * TILE_SIZE, STACK_SIZE = 1 << 20, ROOM = BODY_COUNT };

// The nearest hits of a tile: what the room's tree says, and whatever body is nearer.
struct pixels {
    float t[PIXEL_COUNT], u[PIXEL_COUNT], v[PIXEL_COUNT];
    uint32_t mesh[PIXEL_COUNT], triangle[PIXEL_COUNT];
    int32_t facing[PIXEL_COUNT];
    uint32_t body[PIXEL_COUNT];                                          // or ROOM
    float body_t[PIXEL_COUNT], body_u[PIXEL_COUNT], body_v[PIXEL_COUNT]; // of one body
    uint32_t body_triangle[PIXEL_COUNT];
    int32_t body_facing[PIXEL_COUNT];
    float point[PIXEL_COUNT][3];     // just off the surface, in the world's coordinates
    float own_point[PIXEL_COUNT][3]; // and in those of its body
    float query[PIXEL_COUNT][3];     // what one tree is asked about
    uint32_t skip[PIXEL_COUNT][2];   // with the triangle that the point lies on
    uint8_t shaded[PIXEL_COUNT], answer[PIXEL_COUNT];
};

int32_t drawing_begin(struct drawing *drawing)
{
    const size_t size = drawing->worker_count * sizeof *drawing->workers;
    if (!(drawing->workers = heap_allocate(drawing->heap, size, 64))) return MLRT_ERROR_OUT_OF_MEMORY;
    memset(drawing->workers, 0, size);
    int failed = 0;
    for (uint32_t i = 0; i < drawing->worker_count; i++) {
        struct draw_worker *worker = &drawing->workers[i];
        worker->pixels = heap_allocate(drawing->heap, sizeof *worker->pixels, 64);
        worker->stack = (struct stack){heap_allocate(drawing->heap, STACK_SIZE, 64), STACK_SIZE, 0, 0};
        worker->host = (mlrt_host){sizeof(mlrt_host), 0, &worker->stack, stack_allocate, stack_free, NULL, NULL};
        failed |= !worker->pixels || !worker->stack.start;
    }
    return failed ? MLRT_ERROR_OUT_OF_MEMORY : MLRT_OK;
}

void drawing_end(struct drawing *drawing)
{
    for (uint32_t i = 0; drawing->workers && i < drawing->worker_count; i++) {
        heap_free(drawing->heap, drawing->workers[i].pixels, sizeof(struct pixels), 64);
        heap_free(drawing->heap, drawing->workers[i].stack.start, STACK_SIZE, 64);
    }
    heap_free(drawing->heap, drawing->workers, drawing->worker_count * sizeof *drawing->workers, 64);
}

/* ---- bodies ------------------------------------------------------------------------------------------------------ */

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void camera_vector(const mlrt_camera *camera, float x, float y, float p[3])
{
    for (int k = 0; k < 3; k++) p[k] = camera->d00[k] + x * camera->dx[k] + y * camera->dy[k];
}

// Whether the ball around a body may show in a tile: not if it lies outside of a plane through the eye and an edge.
static int may_show(const struct body *body, const mlrt_camera *camera, const mlrt_tile *tile)
{
    const float x[4] = {0, 1, 1, 0}, y[4] = {0, 0, 1, 1};
    float corner[4][3], middle[3];
    for (int i = 0; i < 4; i++) {
        camera_vector(camera, (float)tile->x + x[i] * (float)tile->width, (float)tile->y + y[i] * (float)tile->height,
                      corner[i]);
    }
    for (int k = 0; k < 3; k++) middle[k] = body->position[k] - camera->eye[k];
    for (int i = 0; i < 4; i++) {
        const float *p = corner[i], *q = corner[(i + 1) % 4], *inside = corner[(i + 2) % 4];
        const float n[3] = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
        const float side = dot(n, inside) < 0 ? -1.0f : 1.0f;
        if (side * dot(n, middle) < -body->radius * sqrtf(dot(n, n))) return 0;
    }
    return 1;
}

// The camera in the body's coordinates: then every ray, and every t, is the same one seen from there.
static mlrt_camera camera_of_body(const mlrt_camera *camera, const struct body *body, const mlrt_tile *tile)
{
    mlrt_camera own = *camera;
    to_body(body, camera->eye, 1, own.eye);
    to_body(body, camera->d00, 0, own.d00);
    to_body(body, camera->dx, 0, own.dx);
    to_body(body, camera->dy, 0, own.dy);
    own.crop_x = tile->x, own.crop_y = tile->y;
    own.crop_width = tile->width, own.crop_height = tile->height;
    return own;
}

// A picture within a picture: the tile's pixels, of another tree, by this worker alone.
static int32_t add_body(const struct drawing *drawing, struct draw_worker *worker, const mlrt_tile *tile, uint32_t body)
{
    struct pixels *p = worker->pixels;
    const size_t count = (size_t)tile->width * tile->height;
    const mlrt_camera camera = camera_of_body(drawing->camera, &drawing->world->bodies[body], tile);
    const mlrt_trace_options options = {.struct_size = sizeof options, .mask = SEEN_BY_CAMERA, .host = &worker->host};
    const mlrt_hits hits = {.struct_size = sizeof hits,
                            .t = {p->body_t, 0, 0},
                            .u = {p->body_u, 0, 0},
                            .v = {p->body_v, 0, 0},
                            .triangle = {p->body_triangle, 0, 0},
                            .facing = {p->body_facing, 0, 0}};
    const int32_t status =
        mlrt_render_tiles(drawing->world->bodies[body].shape->tree, &camera, &options, &hits, NULL, NULL);
    for (size_t i = 0; i < count && status == MLRT_OK; i++) {
        if (!(p->body_t[i] < p->t[i])) continue;
        p->t[i] = p->body_t[i], p->u[i] = p->body_u[i], p->v[i] = p->body_v[i];
        p->mesh[i] = 0, p->triangle[i] = p->body_triangle[i], p->facing[i] = p->body_facing[i];
        p->body[i] = body;
    }
    return status;
}

// What the callback is given is gone when it returns, and not to be changed: bodies go into a copy.
static int32_t find_nearest(const struct drawing *drawing, struct draw_worker *worker, const mlrt_tile *tile)
{
    struct pixels *p = worker->pixels;
    const size_t count = (size_t)tile->width * tile->height;
    memcpy(p->t, tile->t, count * sizeof *p->t);
    memcpy(p->u, tile->u, count * sizeof *p->u);
    memcpy(p->v, tile->v, count * sizeof *p->v);
    memcpy(p->mesh, tile->mesh, count * sizeof *p->mesh);
    memcpy(p->triangle, tile->triangle, count * sizeof *p->triangle);
    memcpy(p->facing, tile->facing, count * sizeof *p->facing);
    for (size_t i = 0; i < count; i++) p->body[i] = ROOM;
    int32_t status = MLRT_OK;
    for (uint32_t body = 0; body < BODY_COUNT && status == MLRT_OK; body++) {
        if (may_show(&drawing->world->bodies[body], drawing->camera, tile))
            status = add_body(drawing, worker, tile, body);
    }
    return status;
}

/* ---- shadows ----------------------------------------------------------------------------------------------------- */

static mlrt_light light_of(const struct world *world)
{
    mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT};
    for (int k = 0; k < 3; k++) light.position[k] = (float)world->room.view.light[k];
    return light;
}

// Points just off the surface, on the side of the eye: exactly so in the tree's own coordinates.
static void place_points(const struct world *world, struct pixels *p, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const int in_room = p->body[i] == ROOM;
        const mlrt_tree *tree = in_room ? world->tree : world->bodies[p->body[i]].shape->tree;
        p->shaded[i] = 0;
        if (p->facing[i] == 0 || mlrt_offset_point(tree, p->mesh[i], p->triangle[i], p->u[i], p->v[i], -p->facing[i],
                                                   p->own_point[i]) != MLRT_OK)
            p->own_point[i][0] = p->own_point[i][1] = p->own_point[i][2] = NAN; // nothing shades what is nowhere
        if (in_room)
            memcpy(p->point[i], p->own_point[i], sizeof p->point[i]);
        else
            to_world(&world->bodies[p->body[i]], p->own_point[i], 1, p->point[i]);
    }
}

// Which of the points in `query` one tree shades: `number` is a body or ROOM. Its own points skip their triangle.
static int32_t add_shadows(const struct world *world, const mlrt_light *light, uint32_t number,
                           struct draw_worker *worker, const mlrt_tile *tile)
{
    struct pixels *p = worker->pixels;
    const size_t count = (size_t)tile->width * tile->height;
    for (size_t i = 0; i < count; i++) {
        const int is_own = p->body[i] == number;
        p->skip[i][0] = is_own ? p->mesh[i] : MLRT_NONE;
        p->skip[i][1] = is_own ? p->triangle[i] : MLRT_NONE;
    }
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = tile->width,
                                .count = count,
                                .positions = {p->query, 0},
                                .skip = {p->skip, 0}};
    const mlrt_trace_options options = {.struct_size = sizeof options, .mask = SEEN_BY_LIGHT, .host = &worker->host};
    const mlrt_array answer = {p->answer, 0, 0};
    const mlrt_tree *tree = number == ROOM ? world->tree : world->bodies[number].shape->tree;
    const int32_t status = mlrt_occluded_points(tree, &points, light, &options, &answer);
    for (size_t i = 0; i < count && status == MLRT_OK; i++) p->shaded[i] |= p->answer[i];
    return status;
}

// Whether something in the ball around a body may lie between a point and the light.
static int may_shade(const struct body *body, const float light[3], const float point[3])
{
    float way[3], middle[3], off[3];
    for (int k = 0; k < 3; k++) way[k] = point[k] - light[k], middle[k] = body->position[k] - light[k];
    float share = dot(way, middle) / dot(way, way);
    if (!(share < 1)) share = 1;
    for (int k = 0; k < 3; k++) off[k] = middle[k] - share * way[k];
    return dot(off, off) <= body->radius * body->radius;
}

static int32_t find_shadows(const struct world *world, struct draw_worker *worker, const mlrt_tile *tile)
{
    struct pixels *p = worker->pixels;
    const size_t count = (size_t)tile->width * tile->height;
    const mlrt_light light = light_of(world);
    place_points(world, p, count);
    memcpy(p->query, p->point, count * sizeof *p->query);
    int32_t status = add_shadows(world, &light, ROOM, worker, tile);
    for (uint32_t number = 0; number < BODY_COUNT && status == MLRT_OK; number++) {
        const struct body *body = &world->bodies[number];
        mlrt_light own_light = light;
        to_body(body, light.position, 1, own_light.position);
        int any = 0;
        for (size_t i = 0; i < count; i++) {
            const int asked = !p->shaded[i] && may_shade(body, light.position, p->point[i]);
            any |= asked;
            if (!asked)
                p->query[i][0] = p->query[i][1] = p->query[i][2] = NAN;
            else if (p->body[i] == number)
                memcpy(p->query[i], p->own_point[i], sizeof p->query[i]);
            else
                to_body(body, p->point[i], 1, p->query[i]);
        }
        if (any) status = add_shadows(world, &own_light, number, worker, tile);
    }
    return status;
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

// The unit normal on the side of the eye: of the room's triangles as they are, of bodies smoothly from their vertices'.
static void normal_of(const struct world *world, const struct pixels *p, size_t i, float n[3])
{
    const struct body *body = p->body[i] == ROOM ? NULL : &world->bodies[p->body[i]];
    const struct scene *mesh = body ? &body->shape->mesh : p->mesh[i] == MESH_ROOM ? &world->room : &world->bulb;
    const uint32_t *corner = mesh->indices + 3 * (size_t)p->triangle[i];
    const float *a = mesh->vertices + 3 * corner[0], *b = mesh->vertices + 3 * corner[1];
    const float *c = mesh->vertices + 3 * corner[2];
    for (int k = 0; k < 3; k++) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        n[k] = (b[l] - a[l]) * (c[m] - a[m]) - (b[m] - a[m]) * (c[l] - a[l]);
        if (!body) continue;
        const float *normals = body->shape->normals;
        n[k] = (1 - p->u[i] - p->v[i]) * normals[3 * corner[0] + (uint32_t)k] +
               p->u[i] * normals[3 * corner[1] + (uint32_t)k] + p->v[i] * normals[3 * corner[2] + (uint32_t)k];
    }
    if (body) to_world(body, (float[3]){n[0], n[1], n[2]}, 0, n);
    const float length = sqrtf(dot(n, n)), scale = length > 0 ? (float)-p->facing[i] / length : 0;
    for (int k = 0; k < 3; k++) n[k] *= scale;
}

static struct material material_of(const struct world *world, const struct pixels *p, size_t i)
{
    struct material material = {{1.0f, 0.93f, 0.75f}, 1.6f}; // the bulb
    if (p->body[i] != ROOM) {
        memcpy(material.colour, world->bodies[p->body[i]].colour, sizeof material.colour);
        material.glow = p->body[i] == BODY_MARKER ? 0.5f : 0;
    } else if (p->mesh[i] == MESH_ROOM) {
        material = world->room.materials[world->room.material_ids[p->triangle[i]]];
    }
    return material;
}

static void shade(const struct world *world, const struct pixels *p, size_t i, const float ray[3], float colour[3])
{
    static const float sky[3] = {0.92f, 1.00f, 1.12f}, ground[3] = {1.10f, 0.98f, 0.86f},
                       lamp[3] = {1.6f, 1.36f, 1.06f};
    const struct material material = material_of(world, p, i);
    const mlrt_light light = light_of(world);
    float n[3], way[3];
    normal_of(world, p, i, n);
    for (int k = 0; k < 3; k++) way[k] = light.position[k] - p->point[i][k];
    const float square = dot(way, way), range = (float)world->room.light_range;
    const float cosine = dot(way, n) / sqrtf(square), eye = -dot(ray, n) / sqrtf(dot(ray, ray));
    const float lit = p->shaded[i] || !(cosine > 0) ? 0 : cosine / (1 + square / (range * range));
    // Something that shines, for bodies: the light's direction mirrored at the normal, against the ray's.
    const float mirrored = (2 * cosine * eye * sqrtf(dot(ray, ray)) * sqrtf(square) + dot(way, ray)) /
                           (sqrtf(dot(ray, ray)) * sqrtf(square));
    float shine = p->body[i] < BODY_MARKER && lit > 0 && mirrored > 0 ? mirrored * mirrored : 0;
    shine = shine * shine * shine * shine * shine * shine;
    for (int k = 0; k < 3; k++) {
        const float around = ground[k] + (sky[k] - ground[k]) * (0.5f + 0.5f * n[1]);
        colour[k] =
            material.colour[k] * (around * (0.10f + 0.22f * eye) + lamp[k] * lit + material.glow) + 0.6f * shine;
    }
}

// Up to 0.6 as it is, from there on ever slower; then a square root, near enough to sRGB and the same everywhere.
static uint8_t tone(float x)
{
    const float y = x <= 0.6f ? x : 0.6f + 0.4f * (x - 0.6f) / (x - 0.6f + 0.4f);
    return (uint8_t)(255 * sqrtf(y > 0 ? y : 0) + 0.5f);
}

int32_t draw_tile(void *user, const mlrt_tile *tile)
{
    const struct drawing *drawing = user;
    struct draw_worker *worker = &drawing->workers[tile->worker];
    struct pixels *p = worker->pixels;
    worker->stack.top = 0; // whatever the last tile needed is gone
    if (find_nearest(drawing, worker, tile) != MLRT_OK) return 1;
    if (find_shadows(drawing->world, worker, tile) != MLRT_OK) return 1;
    for (size_t i = 0; i < (size_t)tile->width * tile->height; i++) {
        const uint32_t x = tile->x + (uint32_t)(i % tile->width), y = tile->y + (uint32_t)(i / tile->width);
        float ray[3], colour[3] = {0.72f, 0.78f, 0.84f};
        camera_vector(drawing->camera, (float)x + 0.5f, (float)y + 0.5f, ray);
        if (p->facing[i] != 0) shade(drawing->world, p, i, ray, colour);
        for (int k = 0; k < 3; k++)
            drawing->rgb[3 * ((size_t)y * drawing->camera->width + x) + (size_t)k] = tone(colour[k]);
    }
    return 0;
}

/* ---- picking ----------------------------------------------------------------------------------------------------- */

uint32_t pick(const struct world *world, const mlrt_camera *camera, float x, float y)
{
    const mlrt_trace_options options = {.struct_size = sizeof options, .mask = SEEN_BY_MOUSE};
    uint32_t picked = ROOM;
    mlrt_ray ray = {.struct_size = sizeof ray};
    mlrt_hit hit = {.struct_size = sizeof hit}, nearest = hit;
    memcpy(ray.origin, camera->eye, sizeof ray.origin);
    camera_vector(camera, x, y, ray.direction);
    if (mlrt_trace_ray(world->tree, &ray, &options, &nearest) != MLRT_OK) return ROOM;
    for (uint32_t number = 0; number < BODY_COUNT; number++) {
        const struct body *body = &world->bodies[number];
        mlrt_ray own = ray;
        to_body(body, ray.origin, 1, own.origin);
        to_body(body, ray.direction, 0, own.direction);
        own.t_max = nearest.t; // what lies behind the nearest so far need not be looked for
        if (mlrt_trace_ray(body->shape->tree, &own, &options, &hit) != MLRT_OK || !(hit.t < nearest.t)) continue;
        nearest = hit;
        picked = number;
    }
    return picked;
}
