/* SPDX-License-Identifier: MIT */
/*
 * mlrt_render_tiles with lights: every pixel's shadows against what they are defined as, bit for bit: the closest hit,
 * the ray that mlrt_shadow_ray tells, and that ray traced by itself, with and without the triangle that it skips. By
 * every method, instruction set and number of threads, into frames and callbacks.
 *
 * Where whole tiles see one triangle and are lit or shaded alike, there is much to be saved and to be done wrong. So
 * most pictures are of walls: with occluders between them and the lights, in planes, at edges and corners of tiles.
 * test_shadow_ray.c is about the rays themselves.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hard_scenes.h"
#include "hostile_rays.h"
#include "support.h"

enum { LIGHT_LIMIT = 8, GUARD = 0xA5 };

#define ALL_OUTPUTS (MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_IDS | MLRT_OUTPUT_FACING)

/* ---- pictures and their answers ---------------------------------------------------------------------------------- */

struct picture {
    const struct fixture *fixture;
    uint64_t seed;
    mlrt_camera camera;
    mlrt_light lights[LIGHT_LIMIT];
    uint32_t light_count;
    uint32_t mask;
    uint32_t width, height; /* of the crop */
    float *origins, *directions;
    struct reference_hit *hits;
    uint8_t *shadows;
    uint8_t *away; /* of these, those of lights on the other side of the triangle */
};

static void print_pixel(const struct picture *picture, size_t i, const char *what)
{
    const float *o = picture->origins + 3 * i, *d = picture->directions + 3 * i;
    print_error("%s, seed %llu: %s\n  pixel (%u, %u) of %u x %u, mask %u: o = (%a, %a, %a), d = (%a, %a, %a)\n",
                picture->fixture->name, (unsigned long long)picture->seed, what, (unsigned)(i % picture->width),
                (unsigned)(i / picture->width), (unsigned)picture->width, (unsigned)picture->height,
                (unsigned)picture->mask, (double)o[0], (double)o[1], (double)o[2], (double)d[0], (double)d[1],
                (double)d[2]);
    print_error("  it sees mesh %u, triangle %u\n", (unsigned)picture->hits[i].mesh,
                (unsigned)picture->hits[i].triangle);
    for (uint32_t k = 0; k < picture->light_count; k++) {
        const mlrt_light *light = &picture->lights[k];
        print_error("  light %u: %s (%a, %a, %a)\n", (unsigned)k, light->kind == MLRT_LIGHT_POINT ? "at" : "from",
                    (double)light->position[0], (double)light->position[1], (double)light->position[2]);
    }
}

static int is_occluded(const struct picture *picture, const mlrt_ray *ray)
{
    const mlrt_trace_options options = {
        .struct_size = sizeof options, .query = MLRT_QUERY_ANY, .method = MLRT_METHOD_RAY, .mask = picture->mask};
    mlrt_hit hit = {.struct_size = sizeof hit};
    assert_int_equal(mlrt_trace_ray(picture->fixture->tree, ray, &options, &hit), MLRT_OK);
    return (int)hit.occluded;
}

/* Finds the shadow of one light at one pixel that hits something. */
static void find_shadow(struct picture *picture, size_t i, uint32_t k)
{
    const mlrt_camera *camera = &picture->camera;
    const mlrt_hit hit = {
        .struct_size = sizeof hit, .mesh = picture->hits[i].mesh, .triangle = picture->hits[i].triangle};
    mlrt_ray ray = {.struct_size = sizeof ray, .t_min = camera->t_min, .t_max = camera->t_max};
    mlrt_ray shadow = {.struct_size = sizeof shadow};
    int32_t faces = -1;
    memcpy(ray.origin, picture->origins + 3 * i, sizeof ray.origin);
    memcpy(ray.direction, picture->directions + 3 * i, sizeof ray.direction);
    int32_t status = mlrt_shadow_ray(picture->fixture->tree, &ray, &hit, &picture->lights[k], &shadow, &faces);
    if (status != MLRT_OK || (faces != 0 && faces != 1)) print_pixel(picture, i, "no shadow ray");
    assert_int_equal(status, MLRT_OK);
    assert_true(faces == 0 || faces == 1);
    int occluded = 1;
    if (faces) {
        occluded = is_occluded(picture, &shadow);
        shadow.flags = 0;
        if (occluded != is_occluded(picture, &shadow)) {
            print_pixel(picture, i, "the triangle shades itself");
            fail();
        }
    }
    picture->shadows[i] |= (uint8_t)(occluded << k);
    picture->away[i] |= (uint8_t)(!faces << k);
}

static void find_answers(struct picture *picture)
{
    camera_crop(&picture->camera, &picture->width, &picture->height);
    size_t count = (size_t)picture->width * picture->height;
    picture->origins = allocate_or_fail(count, 12);
    picture->directions = allocate_or_fail(count, 12);
    picture->hits = allocate_or_fail(count, sizeof *picture->hits);
    picture->shadows = allocate_or_fail(count, 1);
    picture->away = allocate_or_fail(count, 1);
    const mlrt_array origins = {picture->origins, 0, 0}, directions = {picture->directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(&picture->camera, &origins, &directions), MLRT_OK);
    const mlrt_trace_options options = {
        .struct_size = sizeof options, .method = MLRT_METHOD_RAY, .mask = picture->mask};
    const mlrt_hits frame = public_hits(picture->hits, picture->width);
    const mlrt_tree *tree = picture->fixture->tree;
    assert_int_equal(mlrt_render_tiles(tree, &picture->camera, &options, &frame, NULL, NULL), MLRT_OK);
    for (size_t i = 0; i < count; i++) {
        if (picture->hits[i].mesh == MLRT_NONE) continue;
        for (uint32_t k = 0; k < picture->light_count; k++) find_shadow(picture, i, k);
    }
}

static void free_answers(struct picture *picture)
{
    free(picture->origins);
    free(picture->directions);
    free(picture->hits);
    free(picture->shadows);
    free(picture->away);
}

/*
 * Squares of one triangle, by what a light does there: it is on the other side, or all its rays arrive, or none, or
 * some: all but one or all but one do not, or the pixels at the corners are alike but not all others. So that tests of
 * whole tiles know that there were such tiles.
 */
enum { AWAY, LIT, DARK, MIXED, ONE_DIFFERS, CORNERS_ALIKE, SQUARE_KINDS };

static size_t squares_seen[3][SQUARE_KINDS]; /* of 4, 16 and 64 pixels */

static int is_one_triangle(const struct picture *picture, uint32_t x, uint32_t y, uint32_t side)
{
    const struct reference_hit *first = &picture->hits[(size_t)y * picture->width + x];
    for (uint32_t i = 0; i < side * side; i++) {
        const struct reference_hit *hit = &picture->hits[(size_t)(y + i / side) * picture->width + x + i % side];
        if (hit->mesh == MLRT_NONE || hit->triangle != first->triangle || hit->mesh != first->mesh) return 0;
    }
    return 1;
}

static int kind_of_square(const struct picture *picture, uint32_t x, uint32_t y, uint32_t side, uint32_t k)
{
    uint32_t dark = 0, dark_corners = 0;
    for (uint32_t j = 0; j < side; j++) {
        for (uint32_t i = 0; i < side; i++) {
            const size_t at = (size_t)(y + j) * picture->width + x + i;
            if (picture->away[at] >> k & 1) return AWAY;
            const uint32_t is_dark = picture->shadows[at] >> k & 1;
            dark += is_dark;
            if ((i == 0 || i == side - 1) && (j == 0 || j == side - 1)) dark_corners += is_dark;
        }
    }
    if (dark == 0) return LIT;
    if (dark == side * side) return DARK;
    if (dark == 1 || dark == side * side - 1) return ONE_DIFFERS;
    return dark_corners % 4 == 0 ? CORNERS_ALIKE : MIXED;
}

static void count_square(const struct picture *picture, uint32_t x, uint32_t y, uint32_t side, size_t *seen)
{
    if (!is_one_triangle(picture, x, y, side)) return;
    for (uint32_t k = 0; k < picture->light_count; k++) ++seen[kind_of_square(picture, x, y, side, k)];
}

static void count_squares(const struct picture *picture)
{
    for (int level = 0; level < 3; level++) {
        const uint32_t side = 4u << 2 * level;
        for (uint32_t y = 0; y + side <= picture->height; y += side) {
            for (uint32_t x = 0; x + side <= picture->width; x += side)
                count_square(picture, x, y, side, squares_seen[level]);
        }
    }
}

/* ---- ways to render ---------------------------------------------------------------------------------------------- */

struct way {
    mlrt_trace_options options; /* `outputs` are those of the callback */
    uint32_t threads;
    uint32_t frame_outputs; /* likewise, of the frame */
    size_t stride;          /* of `occluded` in the frame */
    size_t gap;             /* bytes after each of its rows */
    int has_frame, has_callback, on_kdtree, counts;
};

struct collected {
    const struct picture *picture;
    uint32_t outputs;
    struct reference_hit *hits;
    uint8_t *occluded;
    unsigned char *times; /* how often each pixel came, or many */
};

static void collect_pixel(struct collected *to, const mlrt_tile *tile, size_t from, size_t at)
{
    struct reference_hit *hit = &to->hits[at];
    to->times[at]++;
    if (!tile->occluded != !(to->outputs & MLRT_OUTPUT_OCCLUDED)) to->times[at] = 100;
    if (tile->occluded) to->occluded[at] = tile->occluded[from];
    if (tile->t) hit->t = tile->t[from];
    if (tile->u) hit->u = tile->u[from];
    if (tile->v) hit->v = tile->v[from];
    if (tile->mesh) hit->mesh = tile->mesh[from];
    if (tile->triangle) hit->triangle = tile->triangle[from];
    if (tile->facing) hit->facing = tile->facing[from];
}

/* Runs in several threads at once: it writes only to pixels of its tile. */
static int32_t collect_tile(void *user, const mlrt_tile *tile)
{
    struct collected *to = user;
    const mlrt_camera *camera = &to->picture->camera;
    for (uint32_t j = 0; j < tile->height; j++) {
        for (uint32_t i = 0; i < tile->width; i++)
            collect_pixel(to, tile, (size_t)j * tile->width + i,
                          (size_t)(tile->y - camera->crop_y + j) * to->picture->width + (tile->x - camera->crop_x + i));
    }
    return 0;
}

static void describe_way(const struct way *way, char *text, size_t size)
{
    char how[200];
    describe("render_tiles with lights", &way->options, way->threads, how, sizeof how);
    snprintf(text, size, "%s%s%s, frame %u, callback %u, stride %u", how, way->on_kdtree ? ", kd-tree" : "",
             way->counts ? ", counting" : "", (unsigned)(way->has_frame ? way->frame_outputs : 0),
             (unsigned)(way->has_callback ? way->options.outputs : 0), (unsigned)way->stride);
}

/* What was asked for is as expected; so are the same outputs without lights. */
static int same_outputs(const struct reference_hit *a, const struct reference_hit *b, uint32_t outputs)
{
    return (!(outputs & MLRT_OUTPUT_T) || bits_of_float(a->t) == bits_of_float(b->t)) &&
           (!(outputs & MLRT_OUTPUT_UV) ||
            (bits_of_float(a->u) == bits_of_float(b->u) && bits_of_float(a->v) == bits_of_float(b->v))) &&
           (!(outputs & MLRT_OUTPUT_IDS) || a->mesh == b->mesh) &&
           (!(outputs & (MLRT_OUTPUT_IDS | MLRT_OUTPUT_TRIANGLE)) || a->triangle == b->triangle) &&
           (!(outputs & MLRT_OUTPUT_FACING) || a->facing == b->facing);
}

static void check_pixels(const struct picture *picture, const struct way *way, const struct reference_hit *hits,
                         const uint8_t *occluded, size_t stride, size_t row, uint32_t outputs)
{
    char text[300];
    for (size_t i = 0; i < (size_t)picture->width * picture->height; i++) {
        const uint8_t *bits = occluded + i / picture->width * row + i % picture->width * stride;
        int is_wrong = !same_outputs(&hits[i], &picture->hits[i], outputs);
        if (outputs & MLRT_OUTPUT_OCCLUDED && *bits != picture->shadows[i]) is_wrong = 1;
        if (!is_wrong) continue;
        describe_way(way, text, sizeof text);
        print_pixel(picture, i, text);
        print_error("  occluded: %#x, not %#x; lights on the other side: %#x\n", (unsigned)*bits,
                    (unsigned)picture->shadows[i], (unsigned)picture->away[i]);
        fail();
    }
}

/* The arrays of a frame that are asked for; `block` is for `occluded`. */
static mlrt_hits make_frame(const struct picture *picture, const struct way *way, struct reference_hit *hits,
                            unsigned char *block)
{
    mlrt_hits frame = public_hits(hits, picture->width);
    if (!(way->frame_outputs & MLRT_OUTPUT_T)) frame.t.data = NULL;
    if (!(way->frame_outputs & MLRT_OUTPUT_UV)) frame.u.data = frame.v.data = NULL;
    if (!(way->frame_outputs & MLRT_OUTPUT_IDS)) frame.mesh.data = NULL;
    if (!(way->frame_outputs & (MLRT_OUTPUT_IDS | MLRT_OUTPUT_TRIANGLE))) frame.triangle.data = NULL;
    if (!(way->frame_outputs & MLRT_OUTPUT_FACING)) frame.facing.data = NULL;
    if (!(way->frame_outputs & MLRT_OUTPUT_OCCLUDED)) return frame;
    const size_t row = picture->width * way->stride + way->gap;
    frame.occluded = (mlrt_array){block, way->stride == 1 ? 0 : way->stride, way->gap ? row : 0};
    return frame;
}

/* Bytes of `occluded` that belong to no pixel are somebody else's. */
static void check_guards(const struct picture *picture, const struct way *way, const unsigned char *block)
{
    const size_t row = picture->width * way->stride + way->gap;
    const int is_wanted = (way->frame_outputs & MLRT_OUTPUT_OCCLUDED) != 0;
    for (size_t i = 0; i < row * picture->height; i++) {
        const size_t in_row = i % row;
        const int is_pixel = in_row % way->stride == 0 && in_row / way->stride < picture->width;
        if (!(is_pixel && is_wanted)) assert_int_equal(block[i], GUARD);
    }
}

static void check_way(const struct picture *picture, const struct way *way)
{
    const size_t count = (size_t)picture->width * picture->height;
    const size_t row = picture->width * way->stride + way->gap;
    struct collected collected = {picture, way->options.outputs, NULL, NULL, NULL};
    collected.hits = allocate_or_fail(count, sizeof *collected.hits);
    collected.occluded = allocate_or_fail(count, 1);
    collected.times = allocate_or_fail(count, 1);
    struct reference_hit *hits = allocate_or_fail(count, sizeof *hits);
    unsigned char *block = allocate_or_fail(row * picture->height, 1);
    mlrt_counters counters = {.struct_size = sizeof counters};
    mlrt_trace_options options = way->options;
    const mlrt_hits frame = make_frame(picture, way, hits, block);
    memset(block, GUARD, row * picture->height);
    memset(collected.occluded, GUARD, count);
    options.pool = shared_pool(way->threads);
    options.lights = picture->lights;
    options.light_count = picture->light_count;
    options.mask = picture->mask;
    if (way->counts) options.counters = &counters;
    const mlrt_tree *tree = way->on_kdtree ? picture->fixture->kdtree : picture->fixture->tree;
    assert_int_equal(mlrt_render_tiles(tree, &picture->camera, &options, way->has_frame ? &frame : NULL,
                                       way->has_callback ? collect_tile : NULL, &collected),
                     MLRT_OK);
    if (way->counts) assert_true(counters.ray_count >= count);
    if (way->has_frame) {
        check_pixels(picture, way, hits, block, way->stride, row, way->frame_outputs);
        check_guards(picture, way, block);
    }
    if (way->has_callback) {
        for (size_t i = 0; i < count; i++) assert_int_equal(collected.times[i], 1);
        check_pixels(picture, way, collected.hits, collected.occluded, 1, picture->width, way->options.outputs);
    }
    free(collected.hits);
    free(collected.occluded);
    free(collected.times);
    free(hits);
    free(block);
}

static uint32_t draw_outputs(struct random *random)
{
    static const uint32_t outputs[] = {0, 0, MLRT_OUTPUT_TRIANGLE, MLRT_OUTPUT_IDS, MLRT_OUTPUT_FACING, ALL_OUTPUTS};
    return MLRT_OUTPUT_OCCLUDED | outputs[draw_below(random, sizeof outputs / sizeof outputs[0])];
}

/* Tiles, threads and where results go are drawn. */
static struct way draw_way(struct random *random, int32_t method, int32_t isa)
{
    static const uint32_t tiles[] = {0, 0, 4, 8, 16, 32, 64, 128, 256, 1024}, threads[] = {0, 1, 3};
    static const size_t strides[] = {1, 1, 3, 20}, gaps[] = {0, 0, 7};
    struct way way = {.options = {.struct_size = sizeof way.options, .method = method, .isa = isa}};
    way.options.initial_tile_size = tiles[draw_below(random, sizeof tiles / sizeof tiles[0])];
    way.options.outputs = draw_outputs(random);
    way.frame_outputs = draw_outputs(random);
    way.threads = threads[draw_below(random, 3)];
    way.stride = strides[draw_below(random, 4)];
    way.gap = gaps[draw_below(random, 3)];
    const uint32_t sink = draw_below(random, 6);
    way.has_frame = sink < 4;
    way.has_callback = sink >= 2;
    if (sink == 2) way.frame_outputs &= ~(uint32_t)MLRT_OUTPUT_OCCLUDED; // only the callback wants shadows
    if (sink == 3) way.options.outputs &= ~(uint32_t)MLRT_OUTPUT_OCCLUDED;
    return way;
}

/* Method tile by every instruction set, and the others in turn. */
static void check_ways(const struct picture *picture, struct random *random, int with_all)
{
    static const int32_t others[] = {MLRT_METHOD_RAY,        MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4,
                                     MLRT_METHOD_MULTILEVEL, MLRT_METHOD_DEFAULT, MLRT_METHOD_TILE};
    for (int32_t isa = MLRT_ISA_AUTO; isa <= MLRT_ISA_NEON; isa++) {
        if (!isa_is_supported(isa)) continue;
        struct way way = draw_way(random, MLRT_METHOD_TILE, isa);
        check_way(picture, &way);
    }
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        struct way way = draw_way(random, others[i], MLRT_ISA_AUTO);
        if (others[i] == MLRT_METHOD_TILE) way.counts = 1;
        way.on_kdtree = others[i] != MLRT_METHOD_TILE;
        if (draw_below(random, 2)) way.options.shortcuts_off = 7;
        if (with_all || draw_below(random, 6) == 0) check_way(picture, &way);
    }
}

/* The picture of a fixture with lights. Answers are freed. */
static void check_picture(struct picture *picture, struct random *random)
{
    static int picture_count;
    find_answers(picture);
    count_squares(picture);
    check_ways(picture, random, picture_count++ % 8 == 0);
    free_answers(picture);
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

static float power_of_ten(struct random *random, double least, double most)
{
    return (float)pow(10, least + (most - least) * (double)draw_range(random, 0, 1));
}

/* A point of the plane of a triangle, not always within it, and `height` times the normal of length 1 off. */
static void point_at_plane(struct random *random, const struct reference_triangle *triangle, double height,
                           float point[3])
{
    static const float steps[] = {0, 0.25f, 0.5f, 1, -0.5f, 2};
    const int is_round = draw_below(random, 2) != 0;
    const double s = (double)(is_round ? steps[draw_below(random, 6)] : draw_range(random, -0.5f, 1.5f));
    const double t = (double)(is_round ? steps[draw_below(random, 6)] : draw_range(random, -0.5f, 1.5f));
    double ab[3], ac[3], n[3], length = 0;
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)triangle->corner[1][k] - (double)triangle->corner[0][k];
        ac[k] = (double)triangle->corner[2][k] - (double)triangle->corner[0][k];
    }
    for (int k = 0; k < 3; k++) {
        n[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
        length += n[k] * n[k];
    }
    for (int k = 0; k < 3; k++) {
        const double off = length > 0 ? height * n[k] / sqrt(length) : 0;
        point[k] = (float)((double)triangle->corner[0][k] + s * ab[k] + t * ac[k] + off);
    }
}

/* A point light at this height, anywhere in a square around 0. */
static mlrt_light draw_light_at(struct random *random, float extent, float height)
{
    const float y = draw_range(random, -extent, extent);
    return light_at(draw_range(random, -extent, extent), y, height);
}

/* A light of any kind for a scene of about this extent around 0. */
static mlrt_light draw_light(struct random *random, const struct picture *picture, float extent)
{
    const struct reference_scene *scene = picture->fixture->reference;
    const size_t count = reference_triangle_count(scene);
    static const struct reference_triangle unit = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0, 0};
    const struct reference_triangle *triangle =
        count ? reference_triangle_at(scene, draw_below(random, (uint32_t)count)) : &unit;
    const mlrt_camera *camera = &picture->camera;
    mlrt_light light = light_at(0, 0, 0);
    float *p = light.position, at[3];
    const int axis = (int)draw_below(random, 3);
    switch (draw_below(random, 16)) {
    case 0:
    case 1:
        draw_point(random, -extent, extent, p);
        break;
    case 2:
        draw_point(random, -3 * extent, 3 * extent, p);
        break;
    case 3: // at the eye, or where the first ray of a parallel camera begins
        memcpy(p, camera->projection == MLRT_PROJECTION_PINHOLE ? camera->eye : camera->d00, sizeof light.position);
        break;
    case 4: // behind the camera
        for (int k = 0; k < 3; k++) p[k] = camera->eye[k] - 3 * camera->d00[k] + draw_range(random, -1, 1);
        break;
    case 5:
        memcpy(p, triangle->corner[draw_below(random, 3)], sizeof light.position);
        break;
    case 6:
        point_at_plane(random, triangle, 0, p);
        break;
    case 7:
    case 8:
        point_at_plane(random, triangle, (double)extent * (double)power_of_ten(random, -6, -2), p);
        break;
    case 9:
        point_at_plane(random, triangle, -(double)extent * (double)power_of_ten(random, -6, -2), p);
        break;
    case 10:
        draw_point(random, -1e6f * extent, 1e6f * extent, p);
        break;
    case 11: // along an axis, with zeros of both signs
        light = light_from(0, 0, 0);
        for (int k = 1; k >= 0; k--) p[k] = draw_below(random, 2) ? -0.0f : 0.0f;
        p[axis] = draw_below(random, 2) ? -1.0f : 1.0f;
        break;
    case 12: // in the plane of a triangle, or nearly
        light.kind = MLRT_LIGHT_DIRECTIONAL;
        reference_difference(triangle->corner[1], triangle->corner[2], p);
        if (draw_below(random, 2)) {
            point_at_plane(random, triangle, (double)extent * (double)power_of_ten(random, -6, -2), at);
            reference_difference(at, triangle->corner[0], p);
        }
        break;
    case 13: // of any length
        light.kind = MLRT_LIGHT_DIRECTIONAL;
        draw_point(random, -1, 1, p);
        const float length = power_of_ten(random, -38, 37);
        for (int k = 0; k < 3; k++) p[k] *= length;
        break;
    default:
        light.kind = MLRT_LIGHT_DIRECTIONAL;
        draw_point(random, -1, 1, p);
        break;
    }
    return light;
}

static void draw_lights(struct random *random, struct picture *picture, float extent)
{
    picture->light_count = 1 + draw_below(random, LIGHT_LIMIT);
    for (uint32_t k = 0; k < picture->light_count; k++) picture->lights[k] = draw_light(random, picture, extent);
}

static struct picture make_picture(const struct fixture *fixture, const mlrt_camera *camera)
{
    return (struct picture){.fixture = fixture, .seed = fixture->seed, .camera = *camera};
}

/* A picture with lights of all kinds. */
static void check_camera_with_lights(const struct fixture *fixture, const mlrt_camera *camera, struct random *random,
                                     float extent)
{
    struct picture picture = make_picture(fixture, camera);
    draw_lights(random, &picture, extent);
    check_picture(&picture, random);
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* Turns and moves it so that nothing lies along axes. The same for the same `turn`. */
static void tilt_point(double turn, float point[3])
{
    for (int round = 0; round < 2; round++) {
        const int i = round, j = (round + 1) % 3;
        const double c = cos(turn), s = sin(turn), x = (double)point[i], y = (double)point[j];
        point[i] = (float)(c * x - s * y);
        point[j] = (float)(s * x + c * y);
    }
}

static void tilt_soup(struct soup *soup, double turn)
{
    for (size_t i = 0; i < 3 * soup->count; i++) tilt_point(turn, soup->corners + 3 * i);
}

/* Two triangles, one of which has all that is near 0. */
static void add_wall(struct soup *soup, float half, float height)
{
    const float corner[3] = {-half, -0.4f * half, height}, side[3] = {2 * half, 0, 0};
    const float other_side[3] = {0, 2 * half, 0};
    soup_add_quad(soup, corner, side, other_side);
}

/* A triangle, a quad, a box, a needle or an edge-on quad above z = least. */
static void add_occluder(struct soup *soup, struct random *random, float extent, float least, float most, float size)
{
    float p[3], side[3], other_side[3], up[3];
    const float height = draw_range(random, least, most);
    draw_point(random, -extent, extent, p);
    draw_point(random, -size, size, side);
    draw_point(random, -size, size, other_side);
    p[2] = height;
    side[2] = other_side[2] = 0;
    const uint32_t kind = draw_below(random, 5);
    if (kind == 1) { // aslant, and not below `least`
        side[2] = draw_range(random, 0, most - height);
        other_side[2] = draw_range(random, 0, most - height);
    }
    if (kind == 2) { // thin
        for (int k = 0; k < 2; k++) other_side[k] *= 1e-3f;
    }
    if (kind == 3) { // upright
        other_side[0] = other_side[1] = 0;
        other_side[2] = draw_range(random, 0.1f, 1) * (most - height);
    }
    for (int k = 0; k < 3; k++) up[k] = p[k] + side[k];
    if (kind == 4) {
        for (int k = 0; k < 3; k++) up[k] = p[k] + fabsf(side[k]) + 0.01f;
        soup_add_box(soup, p, up);
    } else if (draw_below(random, 2)) {
        soup_add_quad(soup, p, side, other_side);
    } else {
        for (int k = 0; k < 3; k++) other_side[k] += p[k];
        soup_add_triangle(soup, p, up, other_side);
    }
}

/* The first third of the triangles, and the others, are meshes of their own with masks. */
static struct fixture fixture_of_masked_soup(const char *name, uint64_t seed, struct soup *soup)
{
    mlrt_mesh meshes[3] = {soup_mesh(soup), soup_mesh(soup), soup_mesh(soup)};
    const size_t ends[4] = {0, soup->count / 3, soup->count / 2, soup->count};
    for (uint32_t m = 0; m < 3; m++) {
        meshes[m].vertices = soup->corners + 9 * ends[m];
        meshes[m].triangle_count = ends[m + 1] - ends[m];
        meshes[m].vertex_count = 3 * meshes[m].triangle_count;
        meshes[m].id = 7 + m;
        meshes[m].mask = m == 0 ? 0 : m; // all bits, 1, 2
    }
    struct fixture fixture = make_fixture(name, seed, meshes, 3);
    free_soup(soup);
    return fixture;
}

/* ---- any scenes, any lights -------------------------------------------------------------------------------------- */

static void random_triangles(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= scaled(8); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        float eye[3], target[3];
        const float extent = draw_range(&random, 0.1f, 1.5f);
        soup_add_random(&soup, &random, 20 + draw_below(&random, 200), 2, extent);
        struct fixture fixture = fixture_of_soup("random triangles", seed, &soup);
        draw_point(&random, -4, 4, eye);
        draw_point(&random, -1, 1, target);
        const mlrt_camera camera = look_at(eye, target, 1, 66, 37);
        check_camera_with_lights(&fixture, &camera, &random, 2);
        free_fixture(&fixture);
    }
}

static struct fixture boxes_in_a_room(uint64_t seed, double turn)
{
    struct random random = {seed};
    struct soup soup = {0};
    const float lo[3] = {-4, -4, -1}, hi[3] = {4, 4, 4};
    soup_add_box(&soup, lo, hi);
    for (int i = 0; i < 12; i++) {
        float from[3], to[3];
        for (int k = 0; k < 3; k++) {
            from[k] = (float)draw_below(&random, 6) - 3;
            to[k] = from[k] + 0.25f + 0.25f * (float)draw_below(&random, 4);
        }
        soup_add_box(&soup, from, to);
    }
    tilt_soup(&soup, turn);
    return fixture_of_soup("boxes in a room", seed, &soup);
}

static void closed_rooms_with_boxes(void **state)
{
    (void)state;
    for (uint64_t seed = 20; seed < 20 + scaled(6); seed++) {
        struct random random = {seed};
        const double turn = seed % 2 ? 0.7 : 0;
        struct fixture fixture = boxes_in_a_room(seed, turn);
        float eye[3], target[3];
        draw_point(&random, -3.5f, 3.5f, eye);
        draw_point(&random, -3.5f, 3.5f, target);
        eye[2] = fabsf(eye[2]);
        tilt_point(turn, eye);
        const mlrt_camera camera = look_at(eye, target, 1.2f, 80, 66);
        check_camera_with_lights(&fixture, &camera, &random, 4);
        free_fixture(&fixture);
    }
}

static void the_room_with_its_lamp(void **state)
{
    (void)state;
    struct random random = {30};
    const float eye[3] = {1, 1, 1.5f}, target[3] = {2, 2.5f, 1};
    struct fixture fixture = fixture_of_example("room");
    const mlrt_camera camera = look_at(eye, target, 1.3f, 128, 72);
    struct picture picture = make_picture(&fixture, &camera);
    picture.lights[0] = light_at(2, 2, 2.2f);
    picture.lights[1] = light_from(0.5f, -0.3f, 0.8f);
    picture.lights[2] = draw_light(&random, &picture, 2);
    picture.light_count = 3;
    check_picture(&picture, &random);
    free_fixture(&fixture);
}

static void hard_scenes_by_hostile_cameras_and_lights(void **state)
{
    (void)state;
    for (size_t i = 0; i < hard_scene_count();
         i += variant_step() + (size_t)hard_scene_at(i)->deep) { // few of the deepest trees
        struct random random = {100 + i};
        struct fixture fixture = make_hard_scene(i);
        mlrt_camera camera = draw_hostile_camera(&random, &fixture, 17 + draw_below(&random, 4));
        while (mlrt_camera_rays(&camera, NULL, NULL) != MLRT_OK) // numbers overflow, or span no picture
            camera = draw_hostile_camera(&random, &fixture, 17);
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 1 + draw_below(&random, 3);
        for (uint32_t k = 0; k < picture.light_count; k++) picture.lights[k] = draw_hostile_light(&random, &fixture);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* ---- walls ------------------------------------------------------------------------------------------------------- */

enum { ABOVE_THE_CAMERA, ANYWHERE, NEAR_THE_WALL, BELOW_TOO };

/* A camera at z = 1 over a wall at z = 0. `turn` tilts everything. */
static mlrt_camera over_the_wall(struct random *random, double turn, uint32_t width, uint32_t height)
{
    float eye[3], target[3];
    const float slant = draw_below(random, 3) ? 1 : 6;
    draw_point(random, -1, 1, eye);
    draw_point(random, -slant, slant, target);
    eye[2] = 1;
    target[2] = 0;
    tilt_point(turn, eye);
    tilt_point(turn, target);
    mlrt_camera camera = look_at(eye, target, draw_range(random, 0.3f, 1.5f), width, height);
    if (draw_below(random, 3)) return camera;
    float direction[3];
    reference_difference(target, eye, direction);
    return look_along(eye, direction, draw_range(random, 0.3f, 2), width, height);
}

static void check_wall(uint64_t seed, int where, uint32_t width, uint32_t height)
{
    struct random random = {seed};
    struct soup soup = {0};
    const double turn = draw_below(&random, 3) ? (double)draw_range(&random, 0, 3) : 0;
    const uint32_t count = 1 + draw_below(&random, draw_below(&random, 2) ? 4 : 40);
    add_wall(&soup, 50, 0);
    for (uint32_t i = 0; i < count; i++) {
        const float size = draw_below(&random, 3) ? 2 : 0.2f;
        if (where == ABOVE_THE_CAMERA) add_occluder(&soup, &random, 4, 1.5f, 6, size);
        if (where == ANYWHERE) add_occluder(&soup, &random, 4, 0, 6, size);
        if (where == NEAR_THE_WALL) add_occluder(&soup, &random, 2, 0, 1e-3f, 0.3f);
        if (where == BELOW_TOO) add_occluder(&soup, &random, 4, -3, 3, size);
    }
    tilt_soup(&soup, turn);
    struct fixture fixture =
        seed % 3 ? fixture_of_soup("wall", seed, &soup) : fixture_of_masked_soup("wall with masks", seed, &soup);
    const mlrt_camera camera = over_the_wall(&random, turn, width, height);
    struct picture picture = make_picture(&fixture, &camera);
    picture.mask = seed % 3 ? 0 : draw_below(&random, 4);
    draw_lights(&random, &picture, 6);
    for (uint32_t k = 0; k < 2 && k < picture.light_count; k++) { // these are surely on the side of the camera
        picture.lights[k] = light_at(0, 0, 0);
        picture.lights[k].kind = (int32_t)draw_below(&random, 2);
        draw_point(&random, -6, 6, picture.lights[k].position);
        picture.lights[k].position[2] = draw_range(&random, 0.2f, 8);
        tilt_point(turn, picture.lights[k].position);
    }
    check_picture(&picture, &random);
    free_fixture(&fixture);
}

static void occluders_above_the_camera(void **state)
{
    (void)state;
    check_wall(200, ABOVE_THE_CAMERA, 200, 150);
    for (uint64_t seed = 201; seed < 201 + scaled(9); seed++) check_wall(seed, ABOVE_THE_CAMERA, 96, 68);
}

static void occluders_between_camera_and_wall(void **state)
{
    (void)state;
    for (uint64_t seed = 220; seed < 220 + scaled(7); seed++) check_wall(seed, ANYWHERE, 96, 68);
}

/* Down to where the end of the ray is. */
static void occluders_that_nearly_touch_the_wall(void **state)
{
    (void)state;
    for (uint64_t seed = 240; seed < 240 + scaled(5); seed++) check_wall(seed, NEAR_THE_WALL, 70, 66);
}

static void what_is_behind_a_wall_does_not_shade_it(void **state)
{
    (void)state;
    for (uint64_t seed = 260; seed < 260 + scaled(6); seed++) check_wall(seed, BELOW_TOO, 70, 66);
}

/* Next to the wall, as many floats off as it takes to be before the end of the ray, or behind it. */
static void sheets_some_floats_above_the_wall(void **state)
{
    (void)state;
    for (uint64_t seed = 280; seed < 280 + scaled(6); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const float height = seed % 2 ? 3 : 0, step = 0x1p-24f;
        add_wall(&soup, 50, height);
        for (int i = 0; i < 40; i++) {
            float corner[3], side[3] = {0.2f, 0, 0}, other_side[3] = {0, 0.2f, 0};
            draw_point(&random, -1, 1, corner);
            corner[2] = height + step * (float)draw_below(&random, 64);
            if (draw_below(&random, 4) == 0) corner[2] = height;
            soup_add_quad(&soup, corner, side, other_side);
        }
        struct fixture fixture = fixture_of_soup("sheets some floats above", seed, &soup);
        const float eye[3] = {0.1f, 0.2f, height + 1}, target[3] = {0.2f, 0.3f, height};
        const mlrt_camera camera = look_at(eye, target, 1.5f, 70, 66);
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 3;
        picture.lights[0] = draw_light_at(&random, 3, height + 2);
        picture.lights[1] = draw_light_at(&random, 3, 2);
        picture.lights[1].kind = MLRT_LIGHT_DIRECTIONAL;
        picture.lights[2] = draw_light_at(&random, 3, height + 1e-4f);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* Lights that nearly lie in the plane of the wall: rays run close above it, and almost along occluders. */
static void lights_close_above_a_wall(void **state)
{
    (void)state;
    static const float heights[] = {1e-2f, 1e-3f, 1e-4f, 1e-5f, 1e-6f, 1e-7f, 1e-8f, 0};
    for (uint64_t seed = 300; seed < 300 + scaled(5); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        add_wall(&soup, 20, 0);
        for (int i = 0; i < 6; i++) add_occluder(&soup, &random, 2, 0, 0.02f, 0.5f);
        const double turn = seed % 2 ? 1.1 : 0;
        tilt_soup(&soup, turn);
        struct fixture fixture = fixture_of_soup("lights close above a wall", seed, &soup);
        const mlrt_camera camera = over_the_wall(&random, turn, 80, 66);
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 8;
        for (uint32_t k = 0; k < 8; k++) {
            const float reach = draw_below(&random, 2) ? 0.5f : 5; // above what is seen, or beside it
            picture.lights[k] = draw_light_at(&random, reach, heights[k]);
            if (draw_below(&random, 4) == 0) picture.lights[k].position[2] = -heights[k];
            if (draw_below(&random, 3) == 0) picture.lights[k].kind = MLRT_LIGHT_DIRECTIONAL;
            tilt_point(turn, picture.lights[k].position);
        }
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* The camera is nearly in the plane of the wall, and a tile is a long strip of it. */
static void walls_seen_at_grazing_angles(void **state)
{
    (void)state;
    static const float heights[] = {0.3f, 1e-2f, 1e-3f, 1e-5f, 1e-6f};
    for (uint64_t i = 0; i < scaled(5); i++) {
        struct random random = {320 + i};
        struct soup soup = {0};
        add_wall(&soup, 50, 0);
        for (int j = 0; j < 6; j++) add_occluder(&soup, &random, 6, 0.5f, 3, 2);
        struct fixture fixture = fixture_of_soup("a wall at a grazing angle", 320 + i, &soup);
        const float eye[3] = {-8, 0.1f, heights[i]}, target[3] = {0, 0, 0};
        const mlrt_camera camera = look_at(eye, target, heights[i] < 1e-4f ? 1e-3f : 0.1f, 80, 66);
        check_camera_with_lights(&fixture, &camera, &random, 5);
        free_fixture(&fixture);
    }
}

/* Two walls with a common edge, at any angle, from either side: a tile sees one, and the other shades it. */
static void walls_that_meet_in_edges(void **state)
{
    (void)state;
    for (uint64_t seed = 340; seed < 340 + scaled(8); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const float corner[3] = {0, -20, 0}, edge[3] = {0, 40, 0}, left[3] = {-20, 0, 0};
        const double angle = seed % 4 == 0 ? 1.5707963267948966 : (double)draw_range(&random, 0.05f, 6.2f);
        const float right[3] = {(float)(20 * cos(angle)), 0, (float)(20 * sin(angle))};
        float eye[3], target[3] = {0};
        soup_add_quad(&soup, corner, edge, left);
        soup_add_quad(&soup, corner, edge, right);
        if (seed % 2) add_occluder(&soup, &random, 1, 1, 3, 1);
        const double turn = draw_below(&random, 2) ? 0.9 : 0;
        tilt_soup(&soup, turn);
        struct fixture fixture = fixture_of_soup("walls that meet", seed, &soup);
        draw_point(&random, -3, 3, eye);
        draw_point(&random, -0.5f, 0.5f, target);
        const mlrt_camera camera = look_at(eye, target, draw_range(&random, 0.2f, 1.2f), 80, 66);
        struct picture picture = make_picture(&fixture, &camera);
        draw_lights(&random, &picture, 4);
        if (draw_below(&random, 2)) { // on the edge itself
            picture.lights[0] = light_at(0, draw_range(&random, -2, 2), 0);
            tilt_point(turn, picture.lights[0].position);
        }
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* Quads of two triangles, each two or three times, cut differently, and small ones in the same plane. */
static void walls_of_coplanar_triangles(void **state)
{
    (void)state;
    for (uint64_t seed = 360; seed < 360 + scaled(6); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        for (int i = 0; i < 3; i++) {
            add_wall(&soup, (float)(20 - i), 0.5f);
            soup_add_random(&soup, &random, 10, 1, 0.5f);
        }
        for (size_t i = 0; i < 3 * soup.count; i++) soup.corners[3 * i + 2] = 0.5f;
        const size_t flat = soup.count;
        for (uint32_t i = 0; i < 1 + seed % 3; i++) add_occluder(&soup, &random, 2, 2, 4, 1.5f);
        const uint32_t doubled = draw_below(&random, 2);
        for (uint32_t i = 0; i < doubled; i++) { // an occluder twice
            float *again = soup.corners + 9 * (flat + i);
            float copy[9];
            memcpy(copy, again, sizeof copy);
            soup_add_triangle(&soup, copy, copy + 3, copy + 6);
        }
        swap_axes(&soup, (int)(seed % 3));
        struct fixture fixture = fixture_of_soup("coplanar triangles", seed, &soup);
        float eye[3] = {0}, target[3] = {0};
        eye[(2 + seed) % 3] = seed % 2 ? 1.5f : -1;
        target[seed % 3] = 0.3f;
        target[(2 + seed) % 3] = 0.5f;
        const mlrt_camera camera = look_at(eye, target, 1, 70, 66);
        check_camera_with_lights(&fixture, &camera, &random, 4);
        free_fixture(&fixture);
    }
}

/*
 * A wall in squares, a copy that is cut along the other diagonal, and another one: their corners lie up to three floats
 * aside. And a fin that nearly touches it. From lights on its side it is lit but where the fin is before it.
 */
static void walls_that_are_there_again_floats_aside(void **state)
{
    (void)state;
    for (uint64_t seed = 370; seed < 370 + scaled(10); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const double turn = draw_range(&random, 0, 2);
        const uint32_t copies = 2 + draw_below(&random, 2), most = draw_below(&random, 4);
        for (uint32_t n = 0; n < copies * 16; n++) {
            const int turned = n / 16 == 1;
            const float corner[3] = {2 * (float)(n % 4) - 4 + (turned ? 2 : 0), 2 * (float)(n / 4 % 4) - 4, 1};
            const float side[3] = {turned ? -2 : 2, 0, 0}, other[3] = {0, 2, 0};
            soup_add_quad(&soup, corner, side, other);
        }
        if (seed % 3) tilt_soup(&soup, turn);
        for (size_t i = 9 * 32; i < 9 * soup.count; i++) {
            soup.corners[i] = next_float(soup.corners[i], (int)draw_below(&random, 2 * most + 1) - (int)most);
        }
        float eye[3] = {0.3f, -1.2f, 3}, target[3] = {0, 0.2f, 1}, fin[3][3] = {{-1, 0, 1}, {1, 0.5f, 1}, {0, 1, 2}};
        for (int i = 0; i < 2; i++) fin[i][2] += draw_below(&random, 2) ? 0 : draw_range(&random, -1e-3f, 1e-3f);
        for (int i = 0; i < 3 && seed % 3; i++) tilt_point(turn, fin[i]);
        if (seed % 3) tilt_point(turn, eye), tilt_point(turn, target);
        if (seed % 2) soup_add_triangle(&soup, fin[0], fin[1], fin[2]);
        struct fixture fixture = fixture_of_soup("walls there again", seed, &soup);
        const mlrt_camera camera = look_at(eye, target, draw_range(&random, 0.4f, 1.2f), 90, 70);
        struct picture picture = make_picture(&fixture, &camera);
        draw_lights(&random, &picture, 4);
        const float above = draw_range(&random, 2, 6);
        picture.lights[0] = draw_light_at(&random, 3, above);
        if (seed % 3) tilt_point(turn, picture.lights[0].position);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* Nothing but one plane: who is on the side of the light is lit, whatever lies in the plane or behind it. */
static void a_plane_does_not_shade_itself(void **state)
{
    (void)state;
    struct random random = {380};
    struct soup soup = {0};
    for (int i = 0; i < 3; i++) add_wall(&soup, 20, 0.7f);
    add_wall(&soup, 30, next_float(0.7f, -1));
    add_wall(&soup, 30, 0.6999f);
    for (int turned = 0; turned < 2; turned++) {
        struct soup copy = {0};
        for (size_t i = 0; i < soup.count; i++) {
            const float *c = soup.corners + 9 * i;
            soup_add_triangle(&copy, c, c + 3, c + 6);
        }
        struct fixture fixture = fixture_of_soup("a plane", (uint64_t)turned, &copy);
        const float eye[3] = {0.1f, 0.2f, 2}, target[3] = {0.3f, 0.1f, 0.7f};
        const mlrt_camera camera = look_at(eye, target, 2, 70, 66);
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 6;
        picture.lights[0] = light_at(3, 4, 5);
        picture.lights[1] = light_at(0, 0, 0.701f);
        picture.lights[2] = light_from(1, 1, 1e-5f);
        picture.lights[3] = light_at(1, 1, 0.7f);
        picture.lights[4] = light_from(1, 1, 0);
        picture.lights[5] = light_at(0, 0, 0.65f);
        find_answers(&picture);
        for (size_t i = 0; i < 70 * 66; i++) assert_int_equal(picture.shadows[i], 0x38);
        check_ways(&picture, &random, 1);
        free_answers(&picture);
        free_fixture(&fixture);
    }
    free_soup(&soup);
}

/* ---- occluders by a hair ----------------------------------------------------------------------------------------- */

/* The ray of a pixel towards a light. 0 if it is on the other side. */
static int ray_of_pixel(const struct picture *picture, uint32_t column, uint32_t row, uint32_t k, mlrt_ray *shadow)
{
    const size_t i = (size_t)row * picture->width + column;
    mlrt_ray ray = {.struct_size = sizeof ray};
    const mlrt_hit hit = {
        .struct_size = sizeof hit, .mesh = picture->hits[i].mesh, .triangle = picture->hits[i].triangle};
    int32_t faces = 0;
    if (hit.mesh == MLRT_NONE) return 0;
    memcpy(ray.origin, picture->origins + 3 * i, sizeof ray.origin);
    memcpy(ray.direction, picture->directions + 3 * i, sizeof ray.direction);
    shadow->struct_size = sizeof *shadow;
    int32_t status = mlrt_shadow_ray(picture->fixture->tree, &ray, &hit, &picture->lights[k], shadow, &faces);
    assert_int_equal(status, MLRT_OK);
    return faces;
}

/* Where rays of pixels pass between wall and light: a point for (0, 0), and for others what is `across` and `down`. */
struct raster {
    double point[3], across[3], down[3];
};

static void point_of_raster(const struct raster *raster, double x, double y, float point[3])
{
    for (int n = 0; n < 3; n++) point[n] = (float)(raster->point[n] + x * raster->across[n] + y * raster->down[n]);
}

static void add_triangle_of_raster(struct soup *soup, struct random *random, const struct raster *raster,
                                   const double xy[6])
{
    float corner[3][3];
    for (int i = 0; i < 3; i++) point_of_raster(raster, xy[2 * i], xy[2 * i + 1], corner[i]);
    const int moved = (int)draw_below(random, 3);
    corner[0][moved] = next_float(corner[0][moved], (int)draw_below(random, 7) - 3);
    soup_add_triangle(soup, corner[0], corner[1], corner[2]);
}

/* A ceiling with a square hole. */
static void add_hole(struct soup *soup, struct random *random, const struct raster *raster, double x, double y,
                     double half)
{
    const double far = 300;
    const double parts[4][4] = {{-far, x - half, -far, far},
                                {x + half, far, -far, far},
                                {x - half, x + half, -far, y - half},
                                {x - half, x + half, y + half, far}};
    for (int i = 0; i < 4; i++) {
        const double *p = parts[i];
        const double first[6] = {p[0], p[2], p[1], p[2], p[1], p[3]}, second[6] = {p[0], p[2], p[1], p[3], p[0], p[3]};
        add_triangle_of_raster(soup, random, raster, first);
        add_triangle_of_raster(soup, random, raster, second);
    }
}

/* 0 if the light is on the other side of the wall. */
static int make_raster(const struct picture *picture, uint32_t column, uint32_t row, uint32_t k, double t,
                       struct raster *raster)
{
    const uint32_t columns[3] = {column, column ? column - 1 : 1, column};
    const uint32_t rows[3] = {row, row, row ? row - 1 : 1};
    double points[3][3];
    for (int i = 0; i < 3; i++) {
        mlrt_ray ray;
        if (!ray_of_pixel(picture, columns[i], rows[i], k, &ray)) return 0;
        for (int n = 0; n < 3; n++) points[i][n] = (double)ray.origin[n] + t * (double)ray.direction[n];
    }
    for (int n = 0; n < 3; n++) {
        raster->point[n] = points[0][n];
        raster->across[n] = (column ? -1 : 1) * (points[1][n] - points[0][n]);
        raster->down[n] = (row ? -1 : 1) * (points[2][n] - points[0][n]);
    }
    return 1;
}

/*
 * An occluder whose shadow ends, give or take a float or two, at the pixel in the corner of a tile, from outside or
 * from inside; or one that shades few pixels within a tile, or all but a few.
 */
static void add_hair(struct soup *soup, struct random *random, const struct picture *picture)
{
    static const uint32_t sides[] = {4, 16, 64, 64};
    const uint32_t side = sides[draw_below(random, 4)], k = draw_below(random, picture->light_count);
    const uint32_t left = draw_below(random, picture->width / side) * side;
    const uint32_t top = draw_below(random, picture->height / side) * side;
    const double x = draw_below(random, 2) ? 1 : -1, y = draw_below(random, 2) ? 1 : -1; // which corner
    const int is_point = picture->lights[k].kind == MLRT_LIGHT_POINT, kind = (int)draw_below(random, 6);
    const double t = (double)(is_point ? draw_range(random, 0.2f, 0.7f) : draw_range(random, 2, 5));
    const double r = side * (double)draw_range(random, 0.2f, 3), half = (double)draw_range(random, 0.2f, 2);
    const int is_within = kind >= 4;
    const uint32_t column = left + (is_within ? draw_below(random, side) : x > 0 ? side - 1 : 0);
    const uint32_t row = top + (is_within ? draw_below(random, side) : y > 0 ? side - 1 : 0);
    const double spear[6] = {0, 0, 1.5 * r * x, 0.5 * r * y, 0.5 * r * x, 1.5 * r * y};
    const double edge[6] = {0, -r, 0, r, r * x, 0}, other_edge[6] = {-r, 0, r, 0, 0, r * y};
    const double cover[6] = {0, 0, -10 * side * x, 3 * side * y, 3 * side * x, -10 * side * y};
    const double spot[6] = {half, 0, -half, half, -half, -half};
    struct raster raster;
    if (!make_raster(picture, column, row, k, t, &raster)) return;
    if (kind == 0) add_triangle_of_raster(soup, random, &raster, spear);
    if (kind == 1) add_triangle_of_raster(soup, random, &raster, draw_below(random, 2) ? edge : other_edge);
    if (kind == 2) add_triangle_of_raster(soup, random, &raster, cover);
    if (kind == 3) add_hole(soup, random, &raster, half * x, half * y, half);
    if (kind == 4) add_triangle_of_raster(soup, random, &raster, spot);
    if (kind == 5) add_hole(soup, random, &raster, 0, 0, half);
}

static void check_hairs(uint64_t seed, uint32_t width, uint32_t height)
{
    struct random random = {seed};
    const double turn = draw_below(&random, 2) ? (double)draw_range(&random, 0, 3) : 0;
    struct soup soup = {0}, wall = {0};
    add_wall(&soup, 50, 0);
    tilt_soup(&soup, turn);
    for (int i = 0; i < 2; i++)
        soup_add_triangle(&wall, soup.corners + 9 * i, soup.corners + 9 * i + 3, soup.corners + 9 * i + 6);
    struct fixture bare = fixture_of_soup("a bare wall", seed, &wall);
    float eye[3] = {0, 0, 0.5f}, target[3] = {0.3f, 0.1f, 0};
    tilt_point(turn, eye);
    tilt_point(turn, target);
    float direction[3];
    reference_difference(target, eye, direction);
    const mlrt_camera camera =
        draw_below(&random, 2) ? look_at(eye, target, 1, width, height) : look_along(eye, direction, 1, width, height);
    struct picture plain = make_picture(&bare, &camera);
    plain.light_count = 1 + draw_below(&random, 3);
    for (uint32_t k = 0; k < plain.light_count; k++) {
        const float above = draw_range(&random, 3, 8);
        plain.lights[k] = draw_light_at(&random, 4, above);
        if (draw_below(&random, 3) == 0) {
            for (int n = 0; n < 3; n++) plain.lights[k].position[n] /= 4;
            plain.lights[k].kind = MLRT_LIGHT_DIRECTIONAL;
        }
        tilt_point(turn, plain.lights[k].position);
    }
    find_answers(&plain);
    const uint32_t count = seed % 2 ? 1 : 2 + draw_below(&random, 4);
    for (uint32_t i = 0; i < count; i++) add_hair(&soup, &random, &plain);
    struct fixture fixture = fixture_of_soup("by a hair", seed, &soup);
    struct picture picture = make_picture(&fixture, &camera);
    memcpy(picture.lights, plain.lights, sizeof plain.lights);
    picture.light_count = plain.light_count;
    check_picture(&picture, &random);
    free_answers(&plain);
    free_fixture(&fixture);
    free_fixture(&bare);
}

static void shadows_that_reach_into_tiles_by_a_hair(void **state)
{
    (void)state;
    check_hairs(400, 192, 128);
    for (uint64_t seed = 401; seed < 401 + scaled(48); seed++) check_hairs(seed, 64, 64);
}

/* Two occluders with a common edge, or a gap of a float, over the middle of tiles: no light comes through an edge. */
static void occluders_that_meet_over_a_tile(void **state)
{
    (void)state;
    for (uint64_t seed = 450; seed < 450 + scaled(6); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const float x = draw_range(&random, -0.2f, 0.2f), slant = draw_range(&random, -0.3f, 0.3f);
        add_wall(&soup, 50, 0);
        for (int part = 0; part < 2; part++) {
            float corner[3] = {x, -20, 2}, side[3] = {part ? 20.0f : -20.0f, 0, 0.5f}, other_side[3] = {slant, 40, 0};
            if (part && seed % 3) corner[0] = next_float(x, seed % 3 == 1 ? 1 : 4000);
            soup_add_quad(&soup, corner, side, other_side);
        }
        struct fixture fixture = fixture_of_soup("occluders that meet", seed, &soup);
        const float eye[3] = {0, 0, 1}, target[3] = {0.1f, 0.05f, 0};
        const mlrt_camera camera = look_at(eye, target, 1, 80, 66);
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 4;
        picture.lights[0] = light_at(0, 0, 4);
        picture.lights[1] = light_from(0.05f, 0.1f, 1);
        picture.lights[2] = light_at(x, 0, 2); // on the edge
        picture.lights[3] = light_at(0.4f, 0.3f, 1000);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* Bars thinner than a pixel's share of the wall, and slits: pixels differ from their neighbours. */
static void bars_and_slits(void **state)
{
    (void)state;
    for (uint64_t seed = 470; seed < 470 + scaled(5); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        add_wall(&soup, 50, 0);
        const float width = power_of_ten(&random, -5, -1), space = draw_range(&random, 0.05f, 0.3f);
        for (int i = -12; i < 12; i++) {
            const float corner[3] = {space * (float)i, -20, 2};
            const float side[3] = {seed % 2 ? space - width : width, 0, 0}, other_side[3] = {0.2f, 40, 0};
            soup_add_quad(&soup, corner, side, other_side);
        }
        tilt_soup(&soup, seed % 3 ? 0.4 : 0);
        struct fixture fixture = fixture_of_soup("bars and slits", seed, &soup);
        const mlrt_camera camera = over_the_wall(&random, seed % 3 ? 0.4 : 0, 80, 66);
        struct picture picture = make_picture(&fixture, &camera);
        draw_lights(&random, &picture, 3);
        picture.lights[0] = light_at(0.1f, 0.3f, 5);
        tilt_point(seed % 3 ? 0.4 : 0, picture.lights[0].position);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* Many triangles in a tile, which shade each other at low light. */
static void height_fields(void **state)
{
    (void)state;
    for (uint64_t seed = 490; seed < 490 + scaled(3); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        enum { CELLS = 40 };
        soup_add_grid(&soup, 2, 0, CELLS);
        float heights[CELLS + 1][CELLS + 1];
        for (int i = 0; i <= CELLS; i++) {
            for (int j = 0; j <= CELLS; j++) heights[i][j] = draw_range(&random, 0, seed % 2 ? 1.5f : 0.1f);
        }
        for (size_t i = 0; i < 3 * soup.count; i++) {
            float *p = soup.corners + 3 * i;
            p[2] = heights[(int)p[0]][(int)p[1]];
        }
        struct fixture fixture = fixture_of_soup("height field", seed, &soup);
        const float eye[3] = {20, -5, 12}, target[3] = {20, 18, 0};
        const mlrt_camera camera = look_at(eye, target, 1, 70, 66);
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 4;
        picture.lights[0] = light_from(1, 0.3f, 0.2f);
        picture.lights[1] = light_at(20, 20, 3);
        picture.lights[2] = draw_light(&random, &picture, 30);
        picture.lights[3] = draw_light(&random, &picture, 30);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* ---- cameras ----------------------------------------------------------------------------------------------------- */

static void parallel_cameras(void **state)
{
    (void)state;
    for (uint64_t seed = 500; seed < 500 + scaled(5); seed++) {
        struct random random = {seed};
        struct fixture fixture = boxes_in_a_room(seed, 0);
        float centre[3], direction[3];
        draw_point(&random, -3, 3, centre);
        draw_point(&random, -1, 1, direction);
        if (seed % 2) direction[seed % 3] = direction[(seed + 1) % 3] = 0;
        const mlrt_camera camera = look_along(centre, direction, 4, 70, 66);
        check_camera_with_lights(&fixture, &camera, &random, 4);
        free_fixture(&fixture);
    }
}

static void pictures_of_any_size_and_crop(void **state)
{
    (void)state;
    static const uint32_t crops[][6] = {
        {1, 1, 0, 0, 1, 1},         {9, 1, 0, 0, 9, 1},
        {3, 70, 0, 0, 3, 70},       {65, 64, 0, 0, 0, 0},
        {90, 90, 3, 5, 70, 66},     {90, 90, 17, 0, 64, 64},
        {200, 200, 130, 131, 0, 0}, {1u << 23, 1u << 23, (1u << 22) - 30, (1u << 22) - 30, 66, 20}};
    struct fixture fixture = boxes_in_a_room(520, 0.3);
    struct random random = {520};
    for (size_t i = 0; i < sizeof crops / sizeof crops[0]; i++) {
        const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
        mlrt_camera camera = look_at(eye, target, 1, crops[i][0], crops[i][1]);
        camera.crop_x = crops[i][2];
        camera.crop_y = crops[i][3];
        camera.crop_width = crops[i][4];
        camera.crop_height = crops[i][5];
        camera.sample_x = draw_range(&random, -1, 1);
        check_camera_with_lights(&fixture, &camera, &random, 4);
    }
    free_fixture(&fixture);
}

/* What the camera's t_min hides from it still shades; so does what lies behind its t_max. */
static void ranges_of_the_camera_are_not_those_of_shadows(void **state)
{
    (void)state;
    static const float ranges[][2] = {{0.9f, 0}, {0, 1.2f}, {0.5f, 1.5f}, {1.05f, 1.1f}, {2, 1}};
    struct random random = {540};
    struct soup soup = {0};
    add_wall(&soup, 50, 0);
    for (int i = 0; i < 8; i++) add_occluder(&soup, &random, 1, 0.2f, 3, 0.7f);
    struct fixture fixture = fixture_of_soup("ranges", 540, &soup);
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const float eye[3] = {0.1f, 0.2f, 1}, target[3] = {0.2f, 0.3f, 0};
        mlrt_camera camera = look_at(eye, target, 1, 70, 66);
        camera.t_min = ranges[i][0];
        camera.t_max = ranges[i][1];
        struct picture picture = make_picture(&fixture, &camera);
        draw_lights(&random, &picture, 3);
        picture.lights[0] = light_at(0.5f, 0.1f, 4);
        check_picture(&picture, &random);
    }
    free_fixture(&fixture);
}

/* Wide views and eyes on triangles: no cells, rays alone. */
static void strange_cameras(void **state)
{
    (void)state;
    struct random random = {550};
    struct fixture fixture = boxes_in_a_room(550, 0);
    static const float fields[] = {8, 100, 1e-4f, 1e-7f};
    for (size_t i = 0; i < 6; i++) {
        float eye[3] = {0.1f, 0.2f, 0.3f}, target[3] = {1, 1, 1};
        if (i >= 4) memcpy(eye, reference_triangle_at(fixture.reference, 20 + 13 * i)->corner[0], sizeof eye);
        mlrt_camera camera = look_at(eye, target, i < 4 ? fields[i] : 1.5f, 40, 36);
        if (i == 5) camera.dx[0] = -0.0f;
        check_camera_with_lights(&fixture, &camera, &random, 4);
    }
    free_fixture(&fixture);
}

static void scenes_of_every_scale(void **state)
{
    (void)state;
    static const int exponents[] = {-149, -140, -126, -110, -98, -60, 60, 98, 110, 120};
    for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
        struct random random = {560 + i};
        struct soup soup = {0};
        const float scale = (float)ldexp(1, exponents[i]), zero[3] = {0, 0, 0};
        add_wall(&soup, 20, 0);
        for (int j = 0; j < 12; j++) add_occluder(&soup, &random, 4, 0.5f, 5, 2);
        if (exponents[i] < -126) { // a few of the smallest floats each
            const float more[3] = {0, 0, 0};
            move_soup(&soup, 64, more);
        }
        move_soup(&soup, scale, zero);
        struct fixture fixture = fixture_of_soup("scaled", 560 + i, &soup);
        const float eye[3] = {0, 0, 1}, target[3] = {0.2f, 0.3f, 0};
        mlrt_camera camera = look_at(eye, target, 1, 40, 36);
        const float unit = exponents[i] < -126 ? 64 * scale : scale;
        for (int k = 0; k < 3; k++) camera.eye[k] *= unit;
        struct picture picture = make_picture(&fixture, &camera);
        picture.light_count = 5;
        picture.lights[0] = light_at(2 * unit, 3 * unit, 6 * unit);
        picture.lights[1] = light_from(0.2f, 0.3f, 1);
        picture.lights[2] = light_from(0.2f * unit, 0.3f * unit, unit);
        picture.lights[3] = light_at(2 * unit, 3 * unit, 0.01f * unit);
        picture.lights[4] = light_at(1, 2, 3);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

static void a_scene_far_from_the_origin(void **state)
{
    (void)state;
    for (uint64_t seed = 580; seed < 582; seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const float far = seed % 2 ? 1e6f : 1e4f, offset[3] = {far, -far, far / 2};
        add_wall(&soup, 50, 0);
        for (int j = 0; j < 12; j++) add_occluder(&soup, &random, 4, 0.5f, 5, 2);
        move_soup(&soup, 16, offset);
        struct fixture fixture = fixture_of_soup("far away", seed, &soup);
        const float eye[3] = {far, -far, far / 2 + 16}, target[3] = {far + 4, -far, far / 2};
        const mlrt_camera camera = look_at(eye, target, 1, 70, 66);
        struct picture picture = make_picture(&fixture, &camera);
        draw_lights(&random, &picture, 2 * far);
        picture.lights[0] = light_at(far + 20, -far, far / 2 + 90);
        check_picture(&picture, &random);
        free_fixture(&fixture);
    }
}

/* ---- bits -------------------------------------------------------------------------------------------------------- */

/* A wall below eight occluders, each with a light above it, whose shadows lie side by side. */
static struct fixture eight_shadows(mlrt_light lights[LIGHT_LIMIT])
{
    struct soup soup = {0};
    add_wall(&soup, 50, 0);
    for (int k = 0; k < LIGHT_LIMIT; k++) {
        const float corner[3] = {(float)k - 0.2f, 0, 2}, side[3] = {0.4f, 0, 0}, other_side[3] = {0, 1, 0};
        soup_add_quad(&soup, corner, side, other_side);
        lights[k] = light_at((float)k, 0.5f, 3);
    }
    return fixture_of_soup("eight shadows", 600, &soup);
}

static mlrt_camera over_eight_shadows(void)
{
    const mlrt_camera camera = {.struct_size = sizeof camera,
                                .projection = MLRT_PROJECTION_PARALLEL,
                                .width = 128,
                                .height = 20,
                                .direction = {0, 0, -1},
                                .d00 = {-1, -0.5f, 1},
                                .dx = {0.078125f, 0, 0},
                                .dy = {0, 0.1f, 0}};
    return camera;
}

static void render_shadows(const struct fixture *fixture, const mlrt_camera *camera, const mlrt_light *lights,
                           uint32_t count, uint8_t *occluded)
{
    const mlrt_trace_options options = {.struct_size = sizeof options, .lights = lights, .light_count = count};
    const mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {occluded, 0, 0}};
    assert_int_equal(mlrt_render_tiles(fixture->tree, camera, &options, &frame, NULL, NULL), MLRT_OK);
}

static void bit_k_is_light_k(void **state)
{
    (void)state;
    mlrt_light lights[LIGHT_LIMIT];
    struct fixture fixture = eight_shadows(lights);
    const mlrt_camera camera = over_eight_shadows();
    static uint8_t all[20 * 128], one[20 * 128];
    unsigned seen = 0;
    render_shadows(&fixture, &camera, lights, LIGHT_LIMIT, all);
    for (uint32_t k = 0; k < LIGHT_LIMIT; k++) {
        const size_t below = (size_t)10 * 128 + (size_t)(((double)k + 1) / 0.078125);
        assert_int_equal(all[below] >> k & 1, 1);
        render_shadows(&fixture, &camera, &lights[k], 1, one);
        for (size_t i = 0; i < sizeof all; i++) assert_int_equal(one[i], all[i] >> k & 1);
        for (size_t i = 0; i < sizeof all; i++) seen |= (unsigned)all[i] << 8 | (uint8_t)~all[i];
    }
    assert_int_equal(seen, 0xFFFF);
    free_fixture(&fixture);
}

static void the_order_of_lights_is_that_of_bits_only(void **state)
{
    (void)state;
    mlrt_light lights[LIGHT_LIMIT], turned[LIGHT_LIMIT];
    struct fixture fixture = eight_shadows(lights);
    const mlrt_camera camera = over_eight_shadows();
    static uint8_t first[20 * 128], second[20 * 128];
    for (int k = 0; k < LIGHT_LIMIT; k++) turned[k] = lights[(k + 3) % LIGHT_LIMIT];
    render_shadows(&fixture, &camera, lights, LIGHT_LIMIT, first);
    render_shadows(&fixture, &camera, turned, LIGHT_LIMIT, second);
    for (size_t i = 0; i < sizeof first; i++) {
        for (int k = 0; k < LIGHT_LIMIT; k++)
            assert_int_equal(second[i] >> k & 1, first[i] >> (k + 3) % LIGHT_LIMIT & 1);
    }
    free_fixture(&fixture);
}

static void misses_have_no_shadow(void **state)
{
    (void)state;
    static uint8_t occluded[80 * 66];
    struct random random = {610};
    struct soup soup = {0};
    const float eye[3] = {0, 0, 4}, target[3] = {0, 0, 0};
    const float corner[3] = {-1, -1, 0}, side[3] = {2, 0, 0}, other_side[3] = {0, 2, 0};
    soup_add_quad(&soup, corner, side, other_side);
    struct fixture fixtures[2] = {make_fixture("empty", 610, NULL, 0), fixture_of_soup("a quad", 610, &soup)};
    for (int i = 0; i < 2; i++) {
        const mlrt_camera camera = look_at(eye, target, 2, 80, 66);
        struct picture picture = make_picture(&fixtures[i], &camera);
        picture.light_count = 3;
        picture.lights[0] = light_at(0, 0, -3); // shades all that is hit
        picture.lights[1] = light_from(1, 2, -3);
        picture.lights[2] = light_at(0, 0, 3);
        render_shadows(&fixtures[i], &camera, picture.lights, 3, occluded);
        find_answers(&picture);
        for (size_t p = 0; p < 80 * 66; p++) assert_int_equal(occluded[p], picture.hits[p].mesh == MLRT_NONE ? 0 : 3);
        check_ways(&picture, &random, 1);
        free_answers(&picture);
        free_fixture(&fixtures[i]);
    }
}

/* No float leads from the second light to the wall, 6e38 away: it counts as one behind the wall. */
static void a_light_beyond_the_range_of_float(void **state)
{
    (void)state;
    static const int32_t methods[] = {MLRT_METHOD_DEFAULT, MLRT_METHOD_RAY};
    const float corner[3] = {-1e38f, -1e38f, -3e38f}, side[3] = {2e38f, 0, 0}, other_side[3] = {0, 2e38f, 0};
    const mlrt_light lights[2] = {light_at(0, 0, -1e38f), light_at(0, 0, 3e38f)};
    const mlrt_camera camera = {.struct_size = sizeof camera,
                                .width = 8,
                                .height = 8,
                                .eye = {0, 0, -2e38f},
                                .d00 = {-0.5f, -0.5f, -1},
                                .dx = {0.125f, 0, 0},
                                .dy = {0, 0.125f, 0}};
    struct soup soup = {0};
    soup_add_quad(&soup, corner, side, other_side);
    struct fixture fixture = fixture_of_soup("a far wall", 613, &soup);
    for (int m = 0; m < 2; m++) {
        uint32_t triangles[64];
        uint8_t occluded[64];
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .method = methods[m], .lights = lights, .light_count = 2};
        const mlrt_hits frame = {
            .struct_size = sizeof frame, .triangle = {triangles, 0, 0}, .occluded = {occluded, 0, 0}};
        assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
        for (int i = 0; i < 64; i++) {
            assert_int_not_equal(triangles[i], MLRT_NONE);
            assert_int_equal(occluded[i], 2);
        }
        for (int i = 0; i < 2; i++) {
            const mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0, 0, -2e38f}, .direction = {0, 0, -1}};
            const mlrt_hit hit = {.struct_size = sizeof hit, .triangle = triangles[36]};
            mlrt_ray shadow = {.struct_size = sizeof shadow};
            int32_t faces = 7;
            assert_int_equal(mlrt_shadow_ray(fixture.tree, &ray, &hit, &lights[i], &shadow, &faces), MLRT_OK);
            assert_int_equal(faces, i == 0);
            assert_int_equal(shadow.direction[2] != 0, i == 0);
        }
    }
    free_fixture(&fixture);
}

/* Walls are two-sided: lights count where the camera is. */
static void a_wall_seen_from_behind(void **state)
{
    (void)state;
    struct soup soup = {0};
    static uint8_t occluded[70 * 66];
    add_wall(&soup, 50, 0);
    struct fixture fixture = fixture_of_soup("a wall", 620, &soup);
    const mlrt_light lights[4] = {light_at(1, 2, 3), light_at(1, 2, -3), light_from(1, 2, 3), light_from(1, 2, -3)};
    for (int behind = 0; behind < 2; behind++) {
        const float eye[3] = {0, 0, behind ? -1.0f : 1.0f}, target[3] = {0.1f, 0.2f, 0};
        const mlrt_camera camera = look_at(eye, target, 1, 70, 66);
        render_shadows(&fixture, &camera, lights, 4, occluded);
        for (size_t i = 0; i < sizeof occluded; i++) assert_int_equal(occluded[i], behind ? 0x5 : 0xA);
    }
    free_fixture(&fixture);
}

/* The end of one ray is the light itself, which leaves no ray: nothing shades that pixel. */
static void a_light_at_the_end_of_its_ray(void **state)
{
    (void)state;
    struct random random = {640};
    struct soup soup = {0};
    add_wall(&soup, 4, 0);
    add_wall(&soup, 4, 1.5f);
    struct fixture fixture = fixture_of_soup("a light at the end of its ray", 640, &soup);
    const mlrt_camera camera = {.struct_size = sizeof camera,
                                .projection = MLRT_PROJECTION_PARALLEL,
                                .width = 33,
                                .height = 33,
                                .direction = {0, 0, -1},
                                .d00 = {-0.5f, -0.5f, 1},
                                .dx = {0.03125f, 0, 0},
                                .dy = {0, 0.03125f, 0}};
    struct picture picture = make_picture(&fixture, &camera);
    mlrt_ray shadow;
    picture.lights[0] = light_at(0, 0, 0x1p-22f);
    picture.lights[1] = light_at(0.25f, 0, 0x1p-22f);
    picture.light_count = 2;
    find_answers(&picture);
    assert_int_equal(ray_of_pixel(&picture, 16, 16, 0, &shadow), 1);
    for (int k = 0; k < 3; k++) assert_true(shadow.direction[k] == 0);
    assert_int_equal(picture.shadows[16 * 33 + 16], 0);
    check_ways(&picture, &random, 1);
    free_answers(&picture);
    free_fixture(&fixture);
}

/* What the picture does not see does not shade. */
static void shadows_see_what_the_mask_sees(void **state)
{
    (void)state;
    struct soup wall = {0}, first = {0}, second = {0};
    static uint8_t occluded[40 * 40];
    add_wall(&wall, 50, 0);
    add_wall(&first, 50, 2);
    add_wall(&second, 50, 3);
    mlrt_mesh meshes[3] = {soup_mesh(&wall), soup_mesh(&first), soup_mesh(&second)};
    meshes[1].mask = 1;
    meshes[2].mask = 2;
    struct fixture fixture = make_fixture("masks", 630, meshes, 3);
    const float eye[3] = {0, 0, 1}, target[3] = {0.1f, 0.2f, 0};
    const mlrt_camera camera = look_at(eye, target, 1, 40, 40);
    const mlrt_light lights[2] = {light_at(0, 0, 2.5f), light_at(0, 0, 5)};
    static const uint32_t masks[] = {0, 1, 2, 3, 4};
    static const uint8_t expected[] = {3, 3, 2, 3, 0};
    for (size_t m = 0; m < 5; m++) {
        for (int32_t method = MLRT_METHOD_DEFAULT; method <= MLRT_METHOD_TILE; method++) {
            const mlrt_trace_options options = {
                .struct_size = sizeof options, .method = method, .mask = masks[m], .lights = lights, .light_count = 2};
            const mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {occluded, 0, 0}};
            const mlrt_tree *tree = method_tree(method, &fixture);
            assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
            for (size_t i = 0; i < sizeof occluded; i++) assert_int_equal(occluded[i], expected[m]);
        }
    }
    free_fixture(&fixture);
    free_soup(&wall);
    free_soup(&first);
    free_soup(&second);
}

/* ---- calls ------------------------------------------------------------------------------------------------------- */

struct asked {
    uint32_t outputs;
    int wrong;
};

static int32_t look_at_outputs(void *user, const mlrt_tile *tile)
{
    struct asked *asked = user;
    if (!tile->occluded != !(asked->outputs & MLRT_OUTPUT_OCCLUDED)) asked->wrong = 1;
    if (!tile->t != !(asked->outputs & MLRT_OUTPUT_T)) asked->wrong = 1;
    if (!tile->mesh != !(asked->outputs & MLRT_OUTPUT_IDS)) asked->wrong = 1;
    return 0;
}

static void a_callback_gets_shadows_if_it_asked_for_them(void **state)
{
    (void)state;
    mlrt_light lights[LIGHT_LIMIT];
    struct fixture fixture = eight_shadows(lights);
    const mlrt_camera camera = over_eight_shadows();
    static uint8_t occluded[20 * 128];
    const mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {occluded, 0, 0}};
    for (uint32_t outputs = 0; outputs < 64; outputs++) {
        for (int with_frame = 0; with_frame < 2; with_frame++) {
            struct asked asked = {outputs, 0};
            const mlrt_trace_options options = {
                .struct_size = sizeof options, .outputs = outputs, .lights = lights, .light_count = 2};
            assert_int_equal(
                mlrt_render_tiles(fixture.tree, &camera, &options, with_frame ? &frame : NULL, look_at_outputs, &asked),
                MLRT_OK);
            assert_int_equal(asked.wrong, 0);
        }
    }
    free_fixture(&fixture);
}

/* Without lights nobody is asked about them, and the callback gets none. */
static void without_lights_there_are_no_shadows(void **state)
{
    (void)state;
    mlrt_light lights[LIGHT_LIMIT];
    struct fixture fixture = eight_shadows(lights);
    const mlrt_camera camera = over_eight_shadows();
    for (int has_array = 0; has_array < 2; has_array++) {
        struct asked asked = {0, 0};
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .outputs = MLRT_OUTPUT_OCCLUDED, .lights = has_array ? lights : NULL};
        assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, NULL, look_at_outputs, &asked), MLRT_OK);
        assert_int_equal(asked.wrong, 0);
    }
    free_fixture(&fixture);
}

/* Every second light is behind the wall that the whole picture shows: whole squares have the same bits. */
static void whole_squares_in_bytes_of_any_stride(void **state)
{
    (void)state;
    enum { WIDTH = 83, HEIGHT = 70, COUNT = WIDTH * HEIGHT, BEHIND = 0xAA, GAP = 0x77 };
    const float corner[3] = {-50, -50, 0}, side[3] = {100, 0, 0}, other_side[3] = {0, 100, 0};
    const float eye[3] = {0.3f, 0.2f, 3}, target[3] = {0, 0, 0};
    const mlrt_camera camera = look_at(eye, target, 1, WIDTH, HEIGHT);
    struct soup soup = {0};
    mlrt_light lights[LIGHT_LIMIT];
    soup_add_quad(&soup, corner, side, other_side);
    struct fixture fixture = fixture_of_soup("a wall", 12, &soup);
    for (int i = 0; i < LIGHT_LIMIT; i++) lights[i] = light_at(0.25f * (float)i, 1, i % 2 ? -2 : 2);
    for (size_t stride = 1; stride <= 5; stride += 2) {
        unsigned char *bytes = allocate_or_fail(COUNT, stride);
        memset(bytes, GAP, COUNT * stride);
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .lights = lights, .light_count = LIGHT_LIMIT};
        const mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {bytes, stride, 0}};
        assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
        for (size_t i = 0; i < COUNT * stride; i++) assert_int_equal(bytes[i], i % stride ? GAP : BEHIND);
        free(bytes);
    }
    free_fixture(&fixture);
}

static int32_t stop_at_third(void *user, const mlrt_tile *tile)
{
    int *count = user;
    (void)tile;
    return ++*count == 3;
}

static void a_callback_can_end_it(void **state)
{
    (void)state;
    mlrt_light lights[LIGHT_LIMIT];
    struct fixture fixture = eight_shadows(lights);
    const mlrt_camera camera = over_eight_shadows();
    int count = 0;
    const mlrt_trace_options options = {.struct_size = sizeof options,
                                        .initial_tile_size = 16,
                                        .outputs = MLRT_OUTPUT_OCCLUDED,
                                        .lights = lights,
                                        .light_count = 8};
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, NULL, stop_at_third, &count),
                     MLRT_ERROR_CANCELLED);
    assert_int_equal(count, 3);
    free_fixture(&fixture);
}

/* The last: of each kind of square that the tests are for there were enough. */
static void there_were_tiles_of_every_kind(void **state)
{
    (void)state;
    static const size_t least[3][SQUARE_KINDS] = {
        {15000, 50000, 15000, 500, 100, 20}, {800, 2500, 800, 80, 25, 30}, {20, 80, 25, 10, 8, 16}};
    for (int level = 0; level < 3; level++) {
        for (int kind = 0; kind < SQUARE_KINDS; kind++) {
            const size_t seen = squares_seen[level][kind];
            if (seen < scaled(least[level][kind]))
                print_error("squares of %u pixels, kind %d: only %zu\n", 4u << 2 * level, kind, seen);
            assert_true(seen >= scaled(least[level][kind]));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles),
        cmocka_unit_test(closed_rooms_with_boxes),
        cmocka_unit_test(the_room_with_its_lamp),
        cmocka_unit_test(hard_scenes_by_hostile_cameras_and_lights),
        cmocka_unit_test(occluders_above_the_camera),
        cmocka_unit_test(occluders_between_camera_and_wall),
        cmocka_unit_test(occluders_that_nearly_touch_the_wall),
        cmocka_unit_test(what_is_behind_a_wall_does_not_shade_it),
        cmocka_unit_test(sheets_some_floats_above_the_wall),
        cmocka_unit_test(lights_close_above_a_wall),
        cmocka_unit_test(walls_seen_at_grazing_angles),
        cmocka_unit_test(walls_that_meet_in_edges),
        cmocka_unit_test(walls_of_coplanar_triangles),
        cmocka_unit_test(walls_that_are_there_again_floats_aside),
        cmocka_unit_test(a_plane_does_not_shade_itself),
        cmocka_unit_test(shadows_that_reach_into_tiles_by_a_hair),
        cmocka_unit_test(occluders_that_meet_over_a_tile),
        cmocka_unit_test(bars_and_slits),
        cmocka_unit_test(height_fields),
        cmocka_unit_test(parallel_cameras),
        cmocka_unit_test(pictures_of_any_size_and_crop),
        cmocka_unit_test(ranges_of_the_camera_are_not_those_of_shadows),
        cmocka_unit_test(strange_cameras),
        cmocka_unit_test(scenes_of_every_scale),
        cmocka_unit_test(a_scene_far_from_the_origin),
        cmocka_unit_test(bit_k_is_light_k),
        cmocka_unit_test(the_order_of_lights_is_that_of_bits_only),
        cmocka_unit_test(misses_have_no_shadow),
        cmocka_unit_test(a_light_beyond_the_range_of_float),
        cmocka_unit_test(a_wall_seen_from_behind),
        cmocka_unit_test(a_light_at_the_end_of_its_ray),
        cmocka_unit_test(shadows_see_what_the_mask_sees),
        cmocka_unit_test(a_callback_gets_shadows_if_it_asked_for_them),
        cmocka_unit_test(without_lights_there_are_no_shadows),
        cmocka_unit_test(whole_squares_in_bytes_of_any_stride),
        cmocka_unit_test(a_callback_can_end_it),
        cmocka_unit_test(there_were_tiles_of_every_kind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
