/* SPDX-License-Identifier: MIT */
/* task.c - scenes, views and rays: see task.h */
#include "task.h"

#include "study/meshes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const kind_names[KIND_COUNT + 1] = {"frame", "lit",  "primary",  "shadow", "sun",
                                                "array", "list", "parallel", "bounce", "lit-frame"};

enum { WIDTH = 16, BLOCK_SIDE = 4, REGION_SIDE = 64, LARGEST_SPHERE = 9 };

static void *allocate(size_t count, size_t size)
{
    void *block = malloc(count ? count * size : 1);
    if (!block) fprintf(stderr, "not enough memory for %zu x %zu bytes\n", count, size);
    return block;
}

/* ---- scenes -------------------------------------------------------------------------------------------------------
 */

// "sphere" or "sphere:N", of about N triangles. Returns -1 if it is neither.
static int sphere_level(const char *word)
{
    if (strncmp(word, "sphere", 6) != 0 || (word[6] && !strchr(":,", word[6]))) return -1;
    const unsigned long count = word[6] == ':' ? strtoul(word + 7, NULL, 10) : 20480;
    int level = 0;
    while (level < LARGEST_SPHERE && (30ul << 2 * level) < count) level++;
    return level;
}

static int load_any_scene(const char *word, const char *views, struct subject *subject)
{
    const int level = sphere_level(word);
    if (level < 0) return load_scene_and_view(word, views, subject->name, &subject->scene);
    snprintf(subject->name, sizeof subject->name, "%.*s", (int)strcspn(word, ","), word);
    return make_sphere((uint32_t)level, NULL, &subject->scene);
}

static int make_normals(struct subject *subject)
{
    const struct scene *scene = &subject->scene;
    subject->normals = allocate(scene->triangle_count + 1, sizeof *subject->normals);
    if (!subject->normals) return 1;
    for (size_t i = 0; i < scene->triangle_count; i++) {
        const float *a = scene->vertices + 3 * (size_t)scene->indices[3 * i];
        const float *b = scene->vertices + 3 * (size_t)scene->indices[3 * i + 1];
        const float *c = scene->vertices + 3 * (size_t)scene->indices[3 * i + 2];
        double e[3], f[3], n[3], square = 0;
        for (int k = 0; k < 3; k++) e[k] = (double)b[k] - a[k], f[k] = (double)c[k] - a[k];
        for (int k = 0; k < 3; k++) {
            n[k] = e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3];
            square += n[k] * n[k];
        }
        const double length = square > 0 ? sqrt(square) : 1;
        for (int k = 0; k < 3; k++) subject->normals[i].n[k] = (float)(n[k] / length);
        subject->normals[i].level = 0;
    }
    subject->normals[scene->triangle_count] = (struct normal){{0, 0, 0}, BACKGROUND_LEVEL};
    return 0;
}

int load_subject(const char *word, const char *views, const char *view, struct subject *subject)
{
    memset(subject, 0, sizeof *subject);
    if (load_any_scene(word, view ? NULL : views, subject)) return 1;
    if (view && read_view(view, &subject->scene.view)) return 1;
    for (int k = 0; k < 3; k++) subject->light[k] = (float)subject->scene.view.light[k];
    return make_normals(subject);
}

int set_size(struct subject *subject, uint32_t size)
{
    subject->pixel_count = (size_t)size * size;
    return camera_of_view(&subject->scene.view, size, size, &subject->camera);
}

void free_subject(struct subject *subject)
{
    free_scene(&subject->scene);
    free(subject->normals);
    memset(subject, 0, sizeof *subject);
}

void camera_direction(const mlrt_camera *camera, uint32_t column, uint32_t row, float direction[3])
{
    const float x = (float)column + camera->sample_x, y = (float)row + camera->sample_y;
    for (int k = 0; k < 3; k++) direction[k] = (camera->d00[k] + x * camera->dx[k]) + y * camera->dy[k];
}

/* ---- streams ------------------------------------------------------------------------------------------------------
 */

// The pixel with a place in an order of regions, in them blocks of 4x4, in them of 2x2, so that any 4, 8 or 16 rays in
// a row from a multiple of their number are neighbours.
static uint32_t pixel_at(uint32_t size, size_t place)
{
    const uint32_t lane = (uint32_t)(place % WIDTH);
    const size_t block = place / WIDTH, blocks_per_region = (REGION_SIDE / BLOCK_SIDE) * (REGION_SIDE / BLOCK_SIDE);
    const size_t region = block / blocks_per_region, in_region = block % blocks_per_region;
    const uint32_t regions_per_row = size / REGION_SIDE;
    uint32_t x = (uint32_t)(region % regions_per_row) * REGION_SIDE;
    uint32_t y = (uint32_t)(region / regions_per_row) * REGION_SIDE;
    x += (uint32_t)(in_region % (REGION_SIDE / BLOCK_SIDE)) * BLOCK_SIDE + (lane & 1) + (lane >> 1 & 2);
    y += (uint32_t)(in_region / (REGION_SIDE / BLOCK_SIDE)) * BLOCK_SIDE + (lane >> 1 & 1) + (lane >> 2 & 2);
    return y * size + x;
}

// Where Embree's rays towards the sun begin: their direction is as long as the light is far.
#define SUN_BEGIN 0.0001f

static int allocate_stream(size_t count, int one_origin, int one_direction, struct stream *stream)
{
    const size_t padded = (count + WIDTH - 1) / WIDTH * WIDTH;
    for (int k = 0; k < 3; k++) {
        stream->directions[k] = one_direction ? NULL : allocate(padded, sizeof(float));
        stream->origins[k] = one_origin ? NULL : allocate(padded, sizeof(float));
        if ((!one_direction && !stream->directions[k]) || (!one_origin && !stream->origins[k])) return 1;
    }
    stream->elements = allocate(padded, sizeof *stream->elements);
    return !stream->elements;
}

static void set_stream_ray(const struct task *task, size_t place, uint32_t element, struct stream *stream)
{
    const float *p = task->origins[element];
    for (int k = 0; k < 3; k++) {
        if (task->kind == SHADOW) {
            stream->directions[k][place] = p[k] - task->subject->light[k];
        } else {
            stream->origins[k][place] = p[k];
            if (task->directions) stream->directions[k][place] = task->directions[element][k];
        }
    }
    stream->elements[place] = element;
}

// Only elements that have a point. In pictures the order is that of blocks, in lists it stays.
static int make_stream(struct task *task)
{
    struct stream *stream = &task->stream;
    const int is_picture = task->kind != LIST && task->kind != BOUNCE;
    if (allocate_stream(task->ray_count, task->kind == SHADOW, task->kind == SUN, stream)) return 1;
    memcpy(stream->origin, task->subject->light, sizeof stream->origin);
    memcpy(stream->direction, task->sun, sizeof stream->direction);
    stream->t_min = task->kind == SUN ? SUN_BEGIN : 0;
    stream->t_max = task->kind == SHADOW ? SHADOW_END : INFINITY;
    for (size_t i = 0; i < task->element_count; i++) {
        const uint32_t element = is_picture ? pixel_at(task->subject->camera.width, i) : (uint32_t)i;
        if (isnan(task->origins[element][0])) continue;
        set_stream_ray(task, stream->count++, element, stream);
    }
    for (size_t i = stream->count; i % WIDTH; i++) set_stream_ray(task, i, stream->elements[stream->count - 1], stream);
    return 0;
}

/* ---- rays ---------------------------------------------------------------------------------------------------------
 */

struct view_hits {
    float *u, *v;
    uint32_t *triangle;
    int32_t *facing;
};

static void free_hits(struct view_hits *hits)
{
    free(hits->u);
    free(hits->v);
    free(hits->triangle);
    free(hits->facing);
}

static int find_hits(const struct subject *subject, const mlrt_tree *tree, mlrt_pool *pool, struct view_hits *hits)
{
    const size_t n = subject->pixel_count;
    hits->u = allocate(n, sizeof *hits->u), hits->v = allocate(n, sizeof *hits->v);
    hits->triangle = allocate(n, sizeof *hits->triangle), hits->facing = allocate(n, sizeof *hits->facing);
    if (!hits->u || !hits->v || !hits->triangle || !hits->facing) return 1;
    const mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool};
    const mlrt_hits frame = {.struct_size = sizeof frame,
                             .u = {hits->u, 0, 0},
                             .v = {hits->v, 0, 0},
                             .triangle = {hits->triangle, 0, 0},
                             .facing = {hits->facing, 0, 0}};
    const int32_t status = mlrt_render_tiles(tree, &subject->camera, &options, &frame, NULL, NULL);
    if (status != MLRT_OK) fprintf(stderr, "cannot trace: %s\n", mlrt_status_string(status));
    return status != MLRT_OK;
}

// Just off the surface, on the side that the ray came from. Returns 0 for a miss.
static int place_point(const mlrt_tree *tree, const struct view_hits *hits, size_t i, float point[3])
{
    return hits->facing[i] != 0 &&
           mlrt_offset_point(tree, 0, hits->triangle[i], hits->u[i], hits->v[i], -hits->facing[i], point) == MLRT_OK;
}

// From the middle of the points to the light.
static void set_sun(struct task *task)
{
    double middle[3] = {0, 0, 0};
    for (size_t i = 0; i < task->element_count; i++) {
        for (int k = 0; k < 3 && !isnan(task->origins[i][0]); k++) middle[k] += task->origins[i][k];
    }
    for (int k = 0; k < 3; k++) {
        task->sun[k] = (float)(task->subject->light[k] - middle[k] / (task->ray_count ? (double)task->ray_count : 1));
    }
}

static int make_shadow_points(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    task->element_count = task->subject->pixel_count;
    task->origins = allocate(task->element_count, sizeof *task->origins);
    task->skip = allocate(task->element_count, sizeof *task->skip);
    if (!task->origins || !task->skip) return 1;
    for (size_t i = 0; i < task->element_count; i++) {
        float *p = task->origins[i];
        task->skip[i][0] = 0, task->skip[i][1] = hits->triangle[i];
        if (place_point(tree, hits, i, p))
            task->ray_count++;
        else
            p[0] = p[1] = p[2] = NAN;
    }
    set_sun(task);
    return 0;
}

// Based on: D. E. Knuth, "The Art of Computer Programming" 2, section 3.3.4: a multiplier for 64 bits.
static double next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 33) / 2147483648.0 * 2 - 1;
}

// A point of the sphere around the tip of the normal is a direction with the density of its cosine.
static void random_direction(uint64_t *state, const float normal[3], int32_t side, float direction[3])
{
    double p[3], square;
    do {
        square = 0;
        for (int k = 0; k < 3; k++) p[k] = next_random(state), square += p[k] * p[k];
    } while (square > 1 || square < 1e-6);
    for (int k = 0; k < 3; k++) direction[k] = (float)(side * (double)normal[k] + 0.999 * p[k] / sqrt(square));
}

static int make_bounces(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    const size_t n = task->subject->pixel_count;
    uint64_t state = 12345;
    task->origins = allocate(n, sizeof *task->origins), task->directions = allocate(n, sizeof *task->directions);
    if (!task->origins || !task->directions) return 1;
    for (size_t i = 0; i < n; i++) {
        if (!place_point(tree, hits, i, task->origins[task->ray_count])) continue;
        random_direction(&state, task->subject->normals[hits->triangle[i]].n, -hits->facing[i],
                         task->directions[task->ray_count++]);
    }
    task->element_count = task->ray_count;
    return 0;
}

// What the view looks at is as large in its picture as in that of the view's camera.
static mlrt_camera parallel_camera(const struct subject *subject)
{
    const struct view *view = &subject->scene.view;
    mlrt_camera camera = subject->camera;
    double away = 0, length = 0;
    for (int k = 0; k < 3; k++) {
        camera.direction[k] =
            camera.d00[k] + 0.5f * (float)camera.width * camera.dx[k] + 0.5f * (float)camera.height * camera.dy[k];
        away += (view->look[k] - view->eye[k]) * (view->look[k] - view->eye[k]);
        length += (double)camera.direction[k] * camera.direction[k];
    }
    const float scale = (float)sqrt(away / length);
    for (int k = 0; k < 3; k++) {
        camera.d00[k] = camera.eye[k] + scale * (camera.d00[k] - camera.direction[k]);
        camera.dx[k] *= scale;
        camera.dy[k] *= scale;
    }
    camera.projection = MLRT_PROJECTION_PARALLEL;
    return camera;
}

static int make_camera_arrays(struct task *task)
{
    task->element_count = task->ray_count = task->subject->pixel_count;
    task->origins = allocate(task->ray_count, sizeof *task->origins);
    task->directions = allocate(task->ray_count, sizeof *task->directions);
    if (!task->origins || !task->directions) return 1;
    const mlrt_array origins = {task->origins, 0, 0}, directions = {task->directions, 0, 0};
    const mlrt_camera parallel = parallel_camera(task->subject);
    return mlrt_camera_rays(task->kind == PARALLEL ? &parallel : &task->subject->camera, &origins, &directions) !=
           MLRT_OK;
}

int make_task(enum kind kind, const struct subject *subject, const mlrt_tree *tree, mlrt_pool *pool, struct task *task)
{
    memset(task, 0, sizeof *task);
    task->kind = kind;
    task->subject = subject;
    task->ray_count = task->element_count = subject->pixel_count;
    if (is_picture(kind)) return 0;
    if (kind == ARRAY || kind == LIST || kind == PARALLEL) return make_camera_arrays(task) || make_stream(task);
    struct view_hits hits = {NULL, NULL, NULL, NULL};
    task->ray_count = 0;
    int failed = find_hits(subject, tree, pool, &hits);
    if (!failed) failed = is_shadow(kind) ? make_shadow_points(tree, &hits, task) : make_bounces(tree, &hits, task);
    free_hits(&hits);
    return failed || make_stream(task);
}

void free_task(struct task *task)
{
    free(task->origins);
    free(task->directions);
    free(task->skip);
    for (int k = 0; k < 3; k++) free(task->stream.origins[k]), free(task->stream.directions[k]);
    free(task->stream.elements);
    memset(task, 0, sizeof *task);
}

/* ---- answers ------------------------------------------------------------------------------------------------------
 */

int make_answers(const struct task *task, struct answers *answers)
{
    const size_t n = (task->element_count + WIDTH - 1) / WIDTH * WIDTH;
    memset(answers, 0, sizeof *answers);
    int failed = 0;
    if (is_shadow(task->kind) || task->kind == LIT) failed = !(answers->occluded = allocate(n, 1));
    if (!is_shadow(task->kind)) failed |= !(answers->triangles = allocate(n, sizeof *answers->triangles));
    if (task->kind >= ARRAY) failed |= !(answers->t = allocate(n, sizeof *answers->t));
    if (task->kind == FRAME || task->kind == LIT) failed |= !(answers->rgba = allocate(n, sizeof *answers->rgba));
    return failed;
}

void free_answers(struct answers *answers)
{
    free(answers->triangles);
    free(answers->t);
    free(answers->occluded);
    free(answers->rgba);
    memset(answers, 0, sizeof *answers);
}
