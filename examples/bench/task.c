/* SPDX-License-Identifier: MIT */
/* task.c - scenes, views and rays: see task.h */
#include "task.h"

#include "common/must.h"
#include "common/timer.h"
#include "study/meshes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const kind_names[KIND_COUNT + 1] = {"frame",   "lit",        "primary",    "shadow",   "sun",    "array",
                                                "list",    "parallel",   "bounce",     "reach",    "mirror", "lens",
                                                "one-way", "hemisphere", "record",     "samples",  "curve",  "panorama",
                                                "area",    "single",     "single-any", "lit-frame"};

enum { WIDTH = 16, BLOCK_SIDE = 4, REGION_SIDE = 64, LARGEST_SPHERE = 9 };

static void *allocate(size_t count, size_t size)
{
    void *block = malloc(count ? count * size : 1);
    if (!block) fprintf(stderr, "not enough memory for %zu x %zu bytes\n", count, size);
    return block;
}

/* ---- scenes -------------------------------------------------------------------------------------------------- */

// "sphere" or "sphere:N", of about N triangles, a word of a list. Returns 0 if it is neither, -1 if N makes no sense.
static long sphere_size(const char *word)
{
    if (strncmp(word, "sphere", 6) != 0 || (word[6] && !strchr(":,", word[6]))) return 0;
    if (word[6] != ':') return 20480;
    char *end;
    const long size = strtol(word + 7, &end, 10);
    return end == word + 7 || (*end && *end != ',') || size < 20 || size > 20l << 2 * LARGEST_SPHERE ? -1 : size;
}

static int load_any_scene(const char *word, const char *views, struct subject *subject)
{
    const long size = sphere_size(word);
    uint32_t level = 0;
    if (size == 0) return load_scene_and_view(word, views, subject->name, &subject->scene);
    if (size < 0) {
        fprintf(stderr, "%.*s: N of sphere:N is a number of triangles, 20 to %ld\n", (int)strcspn(word, ","), word,
                20l << 2 * LARGEST_SPHERE);
        return 1;
    }
    while ((30l << 2 * level) < size) level++;
    snprintf(subject->name, sizeof subject->name, "%.*s", (int)strcspn(word, ","), word);
    return make_sphere(level, NULL, &subject->scene);
}

int make_normals(struct subject *subject)
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

/* ---- streams ------------------------------------------------------------------------------------------------- */

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

// The length of rows of a list that the library has to find by itself, and by which the peer's packets are squares.
static uint32_t untold_row_length(const struct task *task)
{
    return task->kind == PANORAMA || task->kind == AREA ? task->subject->camera.width : 0;
}

// Where Embree's rays towards the sun begin: their direction is as long as the light is far.
#define SUN_BEGIN 0.0001f

static int allocate_limits(const struct task *task, size_t padded, struct stream *stream)
{
    if (!task->records && !task->t_max) return 0;
    if (task->records) stream->t_mins = allocate(padded, sizeof(float));
    stream->t_maxes = allocate(padded, sizeof(float));
    return (task->records && !stream->t_mins) || !stream->t_maxes;
}

static int allocate_stream(const struct task *task, struct stream *stream)
{
    const int one_origin = task->kind == SHADOW, one_direction = task->kind == SUN;
    const size_t padded = (task->ray_count + WIDTH - 1) / WIDTH * WIDTH;
    for (int k = 0; k < 3; k++) {
        stream->directions[k] = one_direction ? NULL : allocate(padded, sizeof(float));
        stream->origins[k] = one_origin ? NULL : allocate(padded, sizeof(float));
        if ((!one_direction && !stream->directions[k]) || (!one_origin && !stream->origins[k])) return 1;
    }
    stream->elements = allocate(padded, sizeof *stream->elements);
    return !stream->elements || allocate_limits(task, padded, stream);
}

void get_ray(const struct task *task, size_t element, struct ray_record *ray)
{
    if (task->records) {
        *ray = task->records[element];
        return;
    }
    memcpy(ray->origin, task->origins[element], sizeof ray->origin);
    memcpy(ray->direction, task->directions[element], sizeof ray->direction);
    ray->t_min = 0;
    ray->t_max = task->t_max ? task->t_max[element] : INFINITY;
}

static void set_stream_point(const struct task *task, size_t place, uint32_t element, struct stream *stream)
{
    const float *p = task->origins[element];
    for (int k = 0; k < 3; k++) {
        if (task->kind == SHADOW) {
            stream->directions[k][place] = p[k] - task->subject->light[k];
        } else {
            stream->origins[k][place] = p[k];
        }
    }
    stream->elements[place] = element;
}

static void set_stream_ray(const struct task *task, size_t place, uint32_t element, struct stream *stream)
{
    struct ray_record ray;
    get_ray(task, element, &ray);
    for (int k = 0; k < 3; k++) {
        stream->origins[k][place] = ray.origin[k];
        stream->directions[k][place] = ray.direction[k];
    }
    if (stream->t_mins) stream->t_mins[place] = ray.t_min;
    if (stream->t_maxes) stream->t_maxes[place] = ray.t_max;
    stream->elements[place] = element;
}

static int has_ray(const struct task *task, size_t element)
{
    return !isnan(task->records ? task->records[element].origin[0] : task->origins[element][0]);
}

// Only elements that have a point. In pictures the order is that of blocks, in lists it stays.
static int make_stream(struct task *task)
{
    struct stream *stream = &task->stream;
    void (*const set)(const struct task *, size_t, uint32_t, struct stream *) =
        is_shadow(task->kind) ? set_stream_point : set_stream_ray;
    if (allocate_stream(task, stream)) return 1;
    memcpy(stream->origin, task->subject->light, sizeof stream->origin);
    memcpy(stream->direction, task->sun, sizeof stream->direction);
    stream->t_min = task->kind == SUN ? SUN_BEGIN : 0;
    stream->t_max = task->kind == SHADOW ? SHADOW_END : INFINITY;
    const uint32_t row_length = task->row_length ? task->row_length : untold_row_length(task);
    for (size_t i = 0; i < task->element_count; i++) {
        const uint32_t element = row_length ? pixel_at(row_length, i) : (uint32_t)i;
        if (has_ray(task, element)) set(task, stream->count++, element, stream);
    }
    for (size_t i = stream->count; i % WIDTH; i++) set(task, i, stream->elements[stream->count - 1], stream);
    return 0;
}

/* ---- rays ---------------------------------------------------------------------------------------------------- */

struct view_hits {
    float *t, *u, *v;
    uint32_t *triangle;
    int32_t *facing;
};

static void free_hits(struct view_hits *hits)
{
    free(hits->t);
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
    hits->t = allocate(n, sizeof *hits->t);
    if (!hits->t || !hits->u || !hits->v || !hits->triangle || !hits->facing) return 1;
    const mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool};
    const mlrt_hits frame = {.struct_size = sizeof frame,
                             .t = {hits->t, 0, 0},
                             .u = {hits->u, 0, 0},
                             .v = {hits->v, 0, 0},
                             .triangle = {hits->triangle, 0, 0},
                             .facing = {hits->facing, 0, 0}};
    const int32_t status = mlrt_render_tiles(tree, &subject->camera, &options, &frame, NULL, NULL);
    return has_failed(status, "trace");
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
    task->row_length = task->subject->camera.width;
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

static int is_reordered(enum kind kind)
{
    return kind == SAMPLES || kind == CURVE || kind == PANORAMA;
}

static int make_camera_arrays(struct task *task)
{
    task->element_count = task->ray_count = task->subject->pixel_count;
    task->row_length = task->kind == LIST || is_reordered(task->kind) ? 0 : task->subject->camera.width;
    task->origins = allocate(task->ray_count, sizeof *task->origins);
    task->directions = allocate(task->ray_count, sizeof *task->directions);
    if (!task->origins || !task->directions) return 1;
    const mlrt_array origins = {task->origins, 0, 0}, directions = {task->directions, 0, 0};
    const mlrt_camera parallel = parallel_camera(task->subject);
    const mlrt_camera *camera = task->kind == PARALLEL ? &parallel : &task->subject->camera;
    return has_failed(mlrt_camera_rays(camera, &origins, &directions), "make the camera's rays");
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalize(double v[3])
{
    const double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; k++) v[k] /= length > 0 ? length : 1;
}

// Pixel (x, y) of a camera, which need not be whole numbers.
static void direction_at(const mlrt_camera *camera, double x, double y, float direction[3])
{
    for (int k = 0; k < 3; k++) direction[k] = (float)(camera->d00[k] + x * camera->dx[k] + y * camera->dy[k]);
}

// The even bits of a number.
static uint32_t even_bits(uint64_t number)
{
    uint32_t bits = 0;
    for (int i = 0; i < 32; i++) bits |= (uint32_t)(number >> 2 * i & 1) << i;
    return bits;
}

static void follow_curve(struct task *task)
{
    const mlrt_camera *camera = &task->subject->camera;
    size_t i = 0;
    for (uint64_t place = 0; i < task->ray_count; place++) {
        const uint32_t x = even_bits(place), y = even_bits(place >> 1);
        if (x < camera->width && y < camera->height) direction_at(camera, x + 0.5, y + 0.5, task->directions[i++]);
    }
}

static void take_samples(struct task *task)
{
    const mlrt_camera *camera = &task->subject->camera;
    uint64_t state = 13579;
    for (size_t i = 0; i < task->ray_count; i++) {
        const size_t block = i / 4, columns = camera->width / 2;
        const double x = 2 * (double)(block % columns) + 1 + next_random(&state);
        direction_at(camera, x, 2 * (double)(block / columns) + 1 + next_random(&state), task->directions[i]);
    }
}

static void look_around(struct task *task)
{
    const struct view *view = &task->subject->scene.view;
    const uint32_t width = task->subject->camera.width, height = task->subject->camera.height;
    const double turn = 6.283185307179586;
    double up[3], ahead[3], side[3];
    for (int k = 0; k < 3; k++) up[k] = view->up[k], ahead[k] = view->look[k] - view->eye[k];
    normalize(up);
    const double along = dot(up, ahead);
    for (int k = 0; k < 3; k++) ahead[k] -= along * up[k];
    normalize(ahead);
    for (int k = 0; k < 3; k++) side[k] = up[(k + 1) % 3] * ahead[(k + 2) % 3] - up[(k + 2) % 3] * ahead[(k + 1) % 3];
    for (size_t i = 0; i < task->ray_count; i++) {
        const double a = turn * ((double)(i % width) + 0.5) / width;
        const double b = turn / 2 * ((double)(i / width) + 0.5) / height;
        for (int k = 0; k < 3; k++)
            task->directions[i][k] = (float)(sin(b) * (cos(a) * ahead[k] + sin(a) * side[k]) + cos(b) * up[k]);
    }
}

static int make_reordered_arrays(struct task *task)
{
    if (make_camera_arrays(task)) return 1;
    (task->kind == SAMPLES ? take_samples : task->kind == CURVE ? follow_curve : look_around)(task);
    return 0;
}

/* ---- rays of renderers --------------------------------------------------------------------------------------- */

#define OFF_SURFACE 1e-5  // of the scene's diagonal
#define TO_LIGHT    1e-4  // of the way: where rays to the light begin
#define NEAR_BY     0.1   // of the diagonal: how far ambient occlusion looks
#define NO_END      1e30f // as renderers write it
#define F_NUMBER    8

static double diagonal_of(const struct scene *scene)
{
    float minimum[3], maximum[3];
    double square = 0;
    scene_bounds(scene, minimum, maximum);
    for (int k = 0; k < 3; k++) square += ((double)maximum[k] - minimum[k]) * ((double)maximum[k] - minimum[k]);
    return sqrt(square);
}

// The unit normal of a hit, on the side that the ray came from.
static void normal_of(const struct subject *subject, const struct view_hits *hits, size_t i, double normal[3])
{
    for (int k = 0; k < 3; k++) normal[k] = -hits->facing[i] * (double)subject->normals[hits->triangle[i]].n[k];
}

static void aim_at(const float light[3], struct ray_record *ray)
{
    for (int k = 0; k < 3; k++) ray->origin[k] += (float)(TO_LIGHT * ((double)light[k] - ray->origin[k]));
    for (int k = 0; k < 3; k++) ray->direction[k] = light[k] - ray->origin[k];
    ray->t_max = 1;
}

static void reflect(const struct subject *subject, size_t pixel, const double normal[3], struct ray_record *ray)
{
    const uint32_t width = subject->camera.width;
    float direction[3];
    double d[3];
    camera_direction(&subject->camera, (uint32_t)(pixel % width), (uint32_t)(pixel / width), direction);
    for (int k = 0; k < 3; k++) d[k] = direction[k];
    normalize(d);
    const double twice = 2 * dot(d, normal);
    for (int k = 0; k < 3; k++) ray->direction[k] = (float)(d[k] - twice * normal[k]);
}

// Upwards, somewhat towards the eye and to the side: the side of most that is seen.
static void set_one_way(const struct view *view, double direction[3])
{
    static const double weights[3] = {1, 0.6, 0.25};
    double up[3], back[3];
    for (int k = 0; k < 3; k++) up[k] = view->up[k], back[k] = view->eye[k] - view->look[k];
    normalize(up);
    normalize(back);
    for (int k = 0; k < 3; k++) {
        const double side = up[(k + 1) % 3] * back[(k + 2) % 3] - up[(k + 2) % 3] * back[(k + 1) % 3];
        direction[k] = weights[0] * up[k] + weights[1] * back[k] + weights[2] * side;
    }
    normalize(direction);
}

// Sets the ray of a hit, whose origin is set. Returns 0 if it has none.
static int make_record(const struct task *task, const struct view_hits *hits, size_t i, double diagonal,
                       const double one_way[3], struct ray_record *ray)
{
    double normal[3];
    normal_of(task->subject, hits, i, normal);
    if (task->kind == REACH) {
        aim_at(task->subject->light, ray);
        return 1;
    }
    ray->t_min = (float)(OFF_SURFACE * diagonal);
    if (task->kind == MIRROR) {
        reflect(task->subject, i, normal, ray);
        return 1;
    }
    for (int k = 0; k < 3; k++) ray->direction[k] = (float)one_way[k];
    ray->t_max = (float)(NEAR_BY * diagonal);
    return dot(normal, one_way) > 0;
}

static int make_records(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    const struct ray_record none = {{NAN, NAN, NAN}, 0, {0, 0, 0}, 0};
    const double diagonal = diagonal_of(&task->subject->scene);
    double one_way[3];
    set_one_way(&task->subject->scene.view, one_way);
    task->element_count = task->subject->pixel_count;
    task->row_length = task->subject->camera.width;
    task->records = allocate(task->element_count, sizeof *task->records);
    if (!task->records) return 1;
    for (size_t i = 0; i < task->element_count; i++) {
        struct ray_record *ray = &task->records[i];
        *ray = (struct ray_record){.t_max = NO_END};
        if (place_point(tree, hits, i, ray->origin) && make_record(task, hits, i, diagonal, one_way, ray))
            task->ray_count++;
        else
            *ray = none;
    }
    return 0;
}

static int make_camera_records(struct task *task)
{
    task->element_count = task->ray_count = task->subject->pixel_count;
    task->row_length = task->subject->camera.width;
    task->records = allocate(task->ray_count, sizeof *task->records);
    if (!task->records) return 1;
    const mlrt_array origins = {task->records->origin, sizeof *task->records, 0};
    const mlrt_array directions = {task->records->direction, sizeof *task->records, 0};
    for (size_t i = 0; i < task->ray_count; i++) task->records[i] = (struct ray_record){.t_max = NO_END};
    return has_failed(mlrt_camera_rays(&task->subject->camera, &origins, &directions), "make the camera's rays");
}

// Of the rays' lengths along the view, at the hits.
static int find_median_depth(const struct subject *subject, const struct view_hits *hits, const double axis[3],
                             double *depth)
{
    size_t count = 0;
    double *depths = allocate(subject->pixel_count, sizeof *depths);
    const uint32_t width = subject->camera.width;
    for (size_t i = 0; i < subject->pixel_count && depths; i++) {
        float d[3];
        if (hits->facing[i] == 0) continue;
        camera_direction(&subject->camera, (uint32_t)(i % width), (uint32_t)(i / width), d);
        depths[count++] = hits->t[i] * (d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]);
    }
    *depth = count ? median(depths, count) : 1;
    free(depths);
    return !depths;
}

// From a random point of the lens to where the pixel's ray meets the plane that is sharp.
static void bend_ray(const mlrt_camera *camera, const double axis[3], double depth, uint64_t *state, float origin[3],
                     float direction[3])
{
    double right[3], down[3], x, y, along = 0;
    for (int k = 0; k < 3; k++) right[k] = camera->dx[k], down[k] = camera->dy[k];
    normalize(right);
    normalize(down);
    do x = next_random(state), y = next_random(state);
    while (x * x + y * y > 1);
    for (int k = 0; k < 3; k++) along += direction[k] * axis[k];
    for (int k = 0; k < 3; k++) {
        const double sharp = camera->eye[k] + depth / along * direction[k];
        origin[k] = (float)(camera->eye[k] + depth / (2 * F_NUMBER) * (x * right[k] + y * down[k]));
        direction[k] = (float)(sharp - origin[k]);
    }
}

static int make_lens_rays(const struct view_hits *hits, struct task *task)
{
    const struct view *view = &task->subject->scene.view;
    double axis[3], depth;
    uint64_t state = 54321;
    for (int k = 0; k < 3; k++) axis[k] = view->look[k] - view->eye[k];
    normalize(axis);
    if (make_camera_arrays(task) || find_median_depth(task->subject, hits, axis, &depth)) return 1;
    for (size_t i = 0; i < task->ray_count; i++) {
        bend_ray(&task->subject->camera, axis, depth, &state, task->origins[i], task->directions[i]);
    }
    return 0;
}

enum { HEMISPHERE_STEP = 4 /* in columns and in rows, from one hit to the next */ };

static void make_hemisphere(const double normal[3], double diagonal, uint64_t *state, struct task *task)
{
    const size_t first = task->ray_count;
    float *point = task->shared_origins[first / HEMISPHERE_RAYS], n[3];
    for (int k = 0; k < 3; k++) n[k] = (float)normal[k], point[k] += (float)(OFF_SURFACE * diagonal * normal[k]);
    for (size_t i = first; i < first + HEMISPHERE_RAYS; i++) {
        memcpy(task->origins[i], point, sizeof task->origins[i]);
        random_direction(state, n, 1, task->directions[i]);
        double d[3];
        for (int k = 0; k < 3; k++) d[k] = task->directions[i][k];
        normalize(d);
        for (int k = 0; k < 3; k++) task->directions[i][k] = (float)d[k];
        task->t_max[i] = (float)(NEAR_BY * diagonal);
    }
    task->ray_count += HEMISPHERE_RAYS;
}

static int make_hemispheres(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    const uint32_t width = task->subject->camera.width, step = HEMISPHERE_STEP;
    const size_t points = task->subject->pixel_count / (step * step), n = points * HEMISPHERE_RAYS;
    const double diagonal = diagonal_of(&task->subject->scene);
    uint64_t state = 67890;
    task->shared_origins = allocate(points, sizeof *task->shared_origins);
    task->origins = allocate(n, sizeof *task->origins), task->directions = allocate(n, sizeof *task->directions);
    task->t_max = allocate(n, sizeof *task->t_max);
    if (!task->shared_origins || !task->origins || !task->directions || !task->t_max) return 1;
    for (size_t i = 0; i < task->subject->pixel_count; i++) {
        double normal[3];
        if (i % width % step || i / width % step) continue;
        if (!place_point(tree, hits, i, task->shared_origins[task->ray_count / HEMISPHERE_RAYS])) continue;
        normal_of(task->subject, hits, i, normal);
        make_hemisphere(normal, diagonal, &state, task);
    }
    task->element_count = task->ray_count;
    return 0;
}

#define LIGHT_SIZE 0.02 // of the diagonal: half of an edge

static int make_area_rays(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    const size_t n = task->subject->pixel_count;
    const double size = LIGHT_SIZE * diagonal_of(&task->subject->scene);
    uint64_t state = 97531;
    task->origins = allocate(n, sizeof *task->origins), task->directions = allocate(n, sizeof *task->directions);
    task->t_max = allocate(n, sizeof *task->t_max);
    if (!task->origins || !task->directions || !task->t_max) return 1;
    for (size_t i = 0; i < n; i++) {
        float *p = task->origins[i];
        task->t_max[i] = 1;
        if (place_point(tree, hits, i, p))
            task->ray_count++;
        else
            p[0] = p[1] = p[2] = NAN;
        for (int k = 0; k < 3; k++)
            task->directions[i][k] = (float)(task->subject->light[k] + size * next_random(&state) - p[k]);
    }
    task->element_count = n;
    return 0;
}

// Off the surface, in a random direction; the first ray of each two is the camera's, or the one of reach.
static void make_single_record(const struct task *task, const struct view_hits *hits, size_t i, double diagonal,
                               uint64_t *state, struct ray_record *ray)
{
    double normal[3];
    float n[3];
    normal_of(task->subject, hits, i, normal);
    for (int k = 0; k < 3; k++) n[k] = (float)normal[k];
    ray->t_min = (float)(OFF_SURFACE * diagonal);
    random_direction(state, n, 1, ray->direction);
}

static int make_single_records(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    const double diagonal = diagonal_of(&task->subject->scene);
    uint64_t state = 24680;
    if (make_camera_records(task)) return 1;
    task->row_length = 0;
    task->ray_count = 0;
    for (size_t i = 0; i < task->element_count; i++) {
        const size_t pixel = i - i % 2; // both of a pair are of the same place
        struct ray_record *ray = &task->records[i];
        if (i % 2 == 0 && task->kind == SINGLE) {
            task->ray_count++;
            continue;
        }
        *ray = (struct ray_record){.t_max = NO_END};
        if (!place_point(tree, hits, pixel, ray->origin)) {
            ray->origin[0] = NAN;
            continue;
        }
        task->ray_count++;
        if (i % 2)
            make_single_record(task, hits, pixel, diagonal, &state, ray);
        else
            aim_at(task->subject->light, ray);
    }
    return 0;
}

static int make_rays_at_hits(const mlrt_tree *tree, const struct view_hits *hits, struct task *task)
{
    switch ((int)task->kind) {
    case SHADOW:
    case SUN:
        return make_shadow_points(tree, hits, task);
    case BOUNCE:
        return make_bounces(tree, hits, task);
    case LENS:
        return make_lens_rays(hits, task);
    case HEMISPHERE:
        return make_hemispheres(tree, hits, task);
    case AREA:
        return make_area_rays(tree, hits, task);
    case SINGLE:
    case SINGLE_ANY:
        return make_single_records(tree, hits, task);
    default:
        return make_records(tree, hits, task);
    }
}

int make_task(enum kind kind, const struct subject *subject, const mlrt_tree *tree, mlrt_pool *pool, struct task *task)
{
    memset(task, 0, sizeof *task);
    task->kind = kind;
    task->subject = subject;
    task->ray_count = task->element_count = subject->pixel_count;
    if (is_picture(kind)) return 0;
    if (kind == ARRAY || kind == LIST || kind == PARALLEL) return make_camera_arrays(task) || make_stream(task);
    if (is_reordered(kind)) return make_reordered_arrays(task) || make_stream(task);
    if (kind == RECORD) return make_camera_records(task) || make_stream(task);
    struct view_hits hits = {.t = NULL};
    task->ray_count = 0;
    int failed = find_hits(subject, tree, pool, &hits);
    if (!failed) failed = make_rays_at_hits(tree, &hits, task);
    free_hits(&hits);
    return failed || make_stream(task);
}

void free_task(struct task *task)
{
    free(task->origins);
    free(task->directions);
    free(task->t_max);
    free(task->shared_origins);
    free(task->records);
    free(task->skip);
    for (int k = 0; k < 3; k++) free(task->stream.origins[k]), free(task->stream.directions[k]);
    free(task->stream.t_mins);
    free(task->stream.t_maxes);
    free(task->stream.elements);
    memset(task, 0, sizeof *task);
}

/* ---- answers ------------------------------------------------------------------------------------------------- */

int make_answers(const struct task *task, struct answers *answers)
{
    const size_t n = (task->element_count + WIDTH - 1) / WIDTH * WIDTH;
    memset(answers, 0, sizeof *answers);
    int failed = 0;
    if (is_yes_or_no(task->kind) || task->kind == LIT) failed = !(answers->occluded = allocate(n, 1));
    if (!is_yes_or_no(task->kind)) failed |= !(answers->triangles = allocate(n, sizeof *answers->triangles));
    if (task->kind >= ARRAY && !is_any(task->kind)) failed |= !(answers->t = allocate(n, sizeof *answers->t));
    if (task->kind == RECORD) {
        failed |= !(answers->u = allocate(n, sizeof *answers->u));
        failed |= !(answers->v = allocate(n, sizeof *answers->v));
        failed |= !(answers->mesh = allocate(n, sizeof *answers->mesh));
    }
    if (task->kind == FRAME || task->kind == LIT) failed |= !(answers->rgba = allocate(n, sizeof *answers->rgba));
    return failed;
}

void free_answers(struct answers *answers)
{
    free(answers->triangles);
    free(answers->t);
    free(answers->u);
    free(answers->v);
    free(answers->mesh);
    free(answers->occluded);
    free(answers->rgba);
    memset(answers, 0, sizeof *answers);
}
