/* SPDX-License-Identifier: MIT */
/*
 * Pictures for the cells of the tile method (camera_cells.c), which decide about pixels whose rays are never made:
 * hostile cameras before few triangles, of which one often covers many pixels, and beside it nearly covers them. Every
 * pixel is compared with the reference, bit for bit, for each instruction set.
 *
 *     test_cells         some seconds
 *     test_cells 100     100 times as many pictures
 *     test_cells 1 SEED  the picture of that seed
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

static size_t effort = 1;
static uint64_t only_seed;

/* ---- comparison -------------------------------------------------------------------------------------------------- */

static void check_cells_by(const struct fixture *fixture, const mlrt_camera *camera, const struct ray_list *list,
                           const struct reference_hit *expected, int32_t method, int32_t isa)
{
    char text[200];
    struct reference_hit *frame = allocate_or_fail(list->count, sizeof *frame);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    uint32_t *ids = allocate_or_fail(list->count, sizeof *ids);
    mlrt_hits all = public_hits(frame, list->row_length);
    const mlrt_hits any = {.struct_size = sizeof any, .occluded = {occluded, 0, 0}};
    const mlrt_hits triangles = {.struct_size = sizeof triangles, .triangle = {ids, 0, 0}};
    mlrt_trace_options options = {.struct_size = sizeof options, .method = method, .isa = isa};
    describe("render_tiles", &options, 0, text, sizeof text);
    assert_int_equal(mlrt_render_tiles(fixture->tree, camera, &options, &all, NULL, NULL), MLRT_OK);
    assert_int_equal(mlrt_render_tiles(fixture->tree, camera, &options, &triangles, NULL, NULL), MLRT_OK);
    options.query = MLRT_QUERY_ANY;
    assert_int_equal(mlrt_render_tiles(fixture->tree, camera, &options, &any, NULL, NULL), MLRT_OK);
    for (size_t i = 0; i < list->count; i++) {
        check_hit(fixture, text, i, &list->rays[i], &expected[i], &frame[i]);
        if (ids[i] != expected[i].triangle || occluded[i] != (expected[i].mesh != MLRT_NONE)) {
            print_difference(fixture, text, i, &list->rays[i], &expected[i], &frame[i]);
            fail_msg("as an id %u; occluded: %d", (unsigned)ids[i], (int)occluded[i]);
        }
    }
    free(frame);
    free(occluded);
    free(ids);
}

static void print_camera(const mlrt_camera *camera)
{
    const float *v[] = {camera->eye, camera->d00, camera->dx, camera->dy};
    static const char *const names[] = {"eye", "d00", "dx", "dy"};
    for (int i = 0; i < 4; i++)
        print_message("%s (%a, %a, %a)\n", names[i], (double)v[i][0], (double)v[i][1], (double)v[i][2]);
    print_message("crop %u %u %u %u, sample %a %a\n", (unsigned)camera->crop_x, (unsigned)camera->crop_y,
                  (unsigned)camera->crop_width, (unsigned)camera->crop_height, (double)camera->sample_x,
                  (double)camera->sample_y);
}

/* Where dx and dy are parallel, after rounding. */
static int is_refused(const mlrt_camera *camera)
{
    const size_t count = (size_t)camera->crop_width * camera->crop_height;
    float *directions = allocate_or_fail(count ? count : (size_t)camera->width * camera->height, 12);
    const mlrt_array out = {directions, 0, 0};
    const mlrt_array none = {NULL, 0, 0};
    const int32_t status = mlrt_camera_rays(camera, &none, &out);
    free(directions);
    return status == MLRT_ERROR_CAMERA;
}

/* Frees the soup. */
static void check_cells(const char *name, uint64_t seed, struct soup *soup, const mlrt_camera *camera)
{
    struct ray_list list = {0};
    if (is_refused(camera)) {
        free_soup(soup);
        return;
    }
    add_camera_rays(&list, camera);
    struct fixture fixture = fixture_of_soup(name, seed, soup);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    trace_reference(&fixture, &list, expected);
    if (only_seed) print_camera(camera);
    check_cells_by(&fixture, camera, &list, expected, MLRT_METHOD_RAY, MLRT_ISA_AUTO);
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        if (isa_is_supported(isa)) check_cells_by(&fixture, camera, &list, expected, MLRT_METHOD_TILE, isa);
    }
    free(expected);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- hostile pictures -------------------------------------------------------------------------------------------- */

static int draw_exponent(struct random *random, int limit)
{
    return (int)draw_below(random, 2 * (uint32_t)limit + 1) - limit;
}

static uint32_t draw_length(struct random *random)
{
    static const uint32_t lengths[] = {1, 2, 3, 4, 5, 7, 8, 12, 15, 16, 17, 20, 33, 47, 64, 65, 80, 130};
    return lengths[draw_below(random, sizeof lengths / sizeof lengths[0])];
}

static float draw_sample(struct random *random)
{
    switch (draw_below(random, 6)) {
    case 0:
        return 0;
    case 1:
        return draw_range(random, -1, 1);
    case 2:
        return draw_range(random, -4000, 4000);
    default:
        return 0.5f;
    }
}

static void turn(float v[3], int turns, int negative)
{
    for (; turns > 0; turns--) {
        const float x = v[0];
        v[0] = v[2];
        v[2] = v[1];
        v[1] = x;
    }
    if (negative) {
        for (int k = 0; k < 3; k++) v[k] = -v[k];
    }
}

/* A pinhole camera at 0; its crop is the picture. */
static mlrt_camera draw_camera(struct random *random)
{
    mlrt_camera camera = {.struct_size = sizeof camera};
    camera.crop_width = draw_length(random);
    camera.crop_height = draw_length(random);
    camera.sample_x = draw_sample(random);
    camera.sample_y = draw_sample(random);
    if (draw_below(random, 4) == 0) camera.crop_x = draw_bits(random) >> (9 + draw_below(random, 20));
    if (draw_below(random, 4) == 0) camera.crop_y = draw_bits(random) >> (9 + draw_below(random, 20));
    const uint32_t limit = 1u << 23;
    if (camera.crop_x > limit - camera.crop_width) camera.crop_x = limit - camera.crop_width;
    if (camera.crop_y > limit - camera.crop_height) camera.crop_y = limit - camera.crop_height;
    camera.width = camera.crop_x + camera.crop_width;
    camera.height = camera.crop_y + camera.crop_height;

    /* Slopes of the first ray, and from one end to the other. */
    const int is_plain = draw_below(random, 3) == 0, is_narrow = draw_below(random, 3) == 0;
    const int exponent = is_narrow ? -(int)draw_below(random, 22) : -2 + (int)draw_below(random, 4);
    const float field = ldexpf(draw_range(random, 1, 2), exponent);
    const float ratio = draw_below(random, 3) ? 1 : ldexpf(1, draw_exponent(random, 14));
    float dx[3] = {field / (float)camera.crop_width, 0, 0}, dy[3] = {0, field / (float)camera.crop_height, 0};
    float start[3] = {draw_range(random, -1, 0) * field, draw_range(random, -1, 0) * field, 1};
    if (is_plain) {
        dx[0] = ldexpf(1, (int)floorf(log2f(dx[0])));
        dy[1] = ldexpf(1, (int)floorf(log2f(dy[1])));
        start[0] = -dx[0] * (float)(camera.crop_width / 2);
        start[1] = -dy[1] * (float)(camera.crop_height / 2);
    } else if (draw_below(random, 2)) {
        for (int k = 0; k < 3; k++) {
            dx[k] += field / (float)camera.crop_width * draw_range(random, -0.5f, 0.5f);
            dy[k] += field / (float)camera.crop_height * draw_range(random, -0.5f, 0.5f);
            start[k] += draw_range(random, -0.5f, 0.5f);
        }
    }
    for (int k = 0; k < 3; k++) {
        dx[k] *= ratio;
        if (draw_below(random, 2)) dy[k] /= ratio;
    }
    const int turns = (int)draw_below(random, 3), negative = (int)draw_below(random, 2);
    const float scale = ldexpf(1, draw_below(random, 3) ? 0 : draw_exponent(random, draw_below(random, 3) ? 50 : 130));
    for (int k = 0; k < 3; k++) {
        start[k] -= ((float)camera.crop_x + camera.sample_x) * dx[k] + ((float)camera.crop_y + camera.sample_y) * dy[k];
    }
    turn(dx, turns, negative);
    turn(dy, turns, negative);
    turn(start, turns, negative);
    for (int k = 0; k < 3; k++) {
        camera.dx[k] = dx[k] * scale;
        camera.dy[k] = dy[k] * scale;
        camera.d00[k] = start[k] * scale;
    }
    return camera;
}

static void pixel_direction(const mlrt_camera *camera, uint32_t column, uint32_t row, float d[3])
{
    reference_pixel_vector(camera->d00, camera->dx, camera->dy, camera->crop_x + column, camera->crop_y + row,
                           camera->sample_x, camera->sample_y, d);
}

/* A point that the ray of some pixel goes through exactly, or nearly, or one beyond the picture. `scale` makes the
 * largest component about 1. */
static void draw_target(struct random *random, const mlrt_camera *camera, float scale, float p[3])
{
    const uint32_t width = camera->crop_width, height = camera->crop_height;
    uint32_t column = draw_below(random, width), row = draw_below(random, height);
    switch (draw_below(random, 4)) {
    case 0: /* at corners of cells */
        column = column / 4 * 4 + (draw_below(random, 2) ? 3 : 0);
        row = row / 4 * 4 + (draw_below(random, 2) ? 3 : 0);
        break;
    case 1:
        column = column / 16 * 16 + (draw_below(random, 2) ? 15 : 0);
        row = row / 16 * 16 + (draw_below(random, 2) ? 15 : 0);
        break;
    case 2: /* outside */
        column += draw_below(random, 2) ? 2 * width : 0;
        row += draw_below(random, 2) ? 2 * height : 0;
        break;
    default:
        break;
    }
    pixel_direction(camera, column, row, p);
    for (int k = 0; k < 3; k++) p[k] *= scale;
    if (draw_below(random, 3) == 0) {
        for (int k = 0; k < 3; k++) p[k] = next_float(p[k], draw_exponent(random, 2));
    }
}

/* The largest component of the directions, as a power of two. */
static float direction_scale(const mlrt_camera *camera)
{
    float d[3], largest = 0;
    pixel_direction(camera, camera->crop_width / 2, camera->crop_height / 2, d);
    for (int k = 0; k < 3; k++) largest = fmaxf(fabsf(d[k]), largest);
    return largest > 0 && isfinite(largest) ? ldexpf(1, -ilogbf(largest)) : 1;
}

/* Triangles with corners on rays, at depths of few different powers of two. */
static void add_targets(struct soup *soup, struct random *random, const mlrt_camera *camera, float scale)
{
    const uint32_t count = 1 + draw_below(random, 20);
    float corner[3][3];
    for (uint32_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            /* Sometimes an edge is that of the triangle before. */
            if (i > 0 && c < 2 && draw_below(random, 2)) continue;
            draw_target(random, camera, scale, corner[c]);
            const float far = draw_below(random, 2) ? 1 : ldexpf(1, draw_exponent(random, 3));
            for (int k = 0; k < 3; k++) corner[c][k] *= far;
        }
        soup_add_triangle(soup, corner[0], corner[1], corner[2]);
        if (draw_below(random, 6) == 0) soup_add_triangle(soup, corner[1], corner[0], corner[2]);
    }
}

/*
 * Walls across an axis, that cover all or a part, at depths that are neighbouring floats, or the same; some are cut up.
 */
static void add_walls(struct soup *soup, struct random *random, int axis, float sign)
{
    const uint32_t count = 1 + draw_below(random, 6);
    const float depth = draw_range(random, 0.5f, 2);
    for (uint32_t i = 0; i < count; i++) {
        float corner[3], side[3] = {0, 0, 0}, other[3] = {0, 0, 0};
        const int j = (axis + 1) % 3, l = (axis + 2) % 3;
        const float size = ldexpf(1, (int)draw_below(random, 6) - 3);
        corner[axis] = sign * next_float(depth, (int)draw_below(random, 3));
        corner[j] = -size * draw_range(random, 0, 1);
        corner[l] = -size * draw_range(random, 0, 1);
        if (draw_below(random, 3) == 0) corner[j] = 0;
        side[j] = other[l] = size;
        if (draw_below(random, 4) == 0) side[axis] = ldexpf(corner[axis], -(int)draw_below(random, 24));
        soup_add_quad(soup, corner, side, other);
    }
}

/* Small integers: planes through the eye, edges towards it, things in common. */
static void add_lattice(struct soup *soup, struct random *random, int axis, float sign)
{
    const uint32_t count = 1 + draw_below(random, 24), extent = 2 + draw_below(random, 20);
    for (uint32_t i = 0; i < count; i++) {
        float corner[3][3];
        const float depth = sign * (float)draw_below(random, 4);
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 3; k++) corner[c][k] = (float)draw_exponent(random, (int)extent);
            if (i % 2) corner[c][axis] = depth;
        }
        soup_add_triangle(soup, corner[0], corner[1], corner[2]);
    }
}

/* Pieces of one plane that is not across an axis: fans around one corner, some of them twice, and whole covers. */
static void add_plane(struct soup *soup, struct random *random, int axis, float sign)
{
    const uint32_t count = 2 + draw_below(random, 12);
    const float along = (float)draw_exponent(random, 4) / 4, up = (float)draw_exponent(random, 4) / 4;
    for (uint32_t i = 0; i < count; i++) {
        float corner[3][3];
        for (int c = 0; c < 3; c++) {
            const int limit = i % 3 == 2 ? 4000 : 8;
            const float x = (float)draw_exponent(random, limit), y = (float)draw_exponent(random, limit);
            corner[c][(axis + 1) % 3] = x;
            corner[c][(axis + 2) % 3] = y;
            corner[c][axis] = sign * (8 + along * x + up * y);
        }
        soup_add_triangle(soup, corner[0], corner[1], corner[2]);
    }
}

/* Needles that go by the eye from far behind to far in front. */
static void add_needles(struct soup *soup, struct random *random)
{
    const uint32_t count = 1 + draw_below(random, 12);
    for (uint32_t i = 0; i < count; i++) {
        float corner[3][3];
        for (int c = 0; c < 3; c++) {
            const float size = ldexpf(1, c == 2 ? -(int)draw_below(random, 20) : (int)draw_below(random, 20));
            draw_point(random, -size, size, corner[c]);
        }
        if (draw_below(random, 2)) {
            for (int k = 0; k < 3; k++) corner[2][k] += corner[0][k];
        }
        soup_add_triangle(soup, corner[0], corner[1], corner[2]);
    }
}

static void check_hostile_picture(uint64_t seed)
{
    struct random random = {seed * 0x9E3779B97F4A7C15u + 11};
    struct soup soup = {0};
    mlrt_camera camera = draw_camera(&random);
    const float scale = direction_scale(&camera);
    float middle[3];
    pixel_direction(&camera, camera.crop_width / 2, camera.crop_height / 2, middle);
    int axis = 0;
    for (int k = 1; k < 3; k++) axis = fabsf(middle[k]) > fabsf(middle[axis]) ? k : axis;
    const float sign = middle[axis] < 0 ? -1 : 1;
    for (uint32_t parts = 1 + draw_below(&random, 2); parts > 0; parts--) {
        switch (draw_below(&random, 7)) {
        case 0:
        case 1:
            add_targets(&soup, &random, &camera, scale);
            break;
        case 2:
            add_walls(&soup, &random, axis, sign);
            break;
        case 3:
            add_lattice(&soup, &random, axis, sign);
            break;
        case 4:
            add_plane(&soup, &random, axis, sign);
            break;
        case 5:
            add_needles(&soup, &random);
            break;
        default: {
            const float extent = draw_range(&random, 0.05f, 8);
            soup_add_random(&soup, &random, 1 + draw_below(&random, 60), 4, extent);
        }
        }
    }
    /* The eye elsewhere: in a plane, at a corner, anywhere. */
    if (draw_below(&random, 3) == 0) {
        const float *corner = soup.corners + 3 * (size_t)draw_below(&random, 3 * (uint32_t)soup.count);
        for (int k = 0; k < 3; k++) {
            if (draw_below(&random, 2)) camera.eye[k] = draw_below(&random, 2) ? corner[k] : draw_range(&random, -1, 1);
        }
    }
    /* All of it elsewhere, or larger. */
    float offset[3] = {0, 0, 0};
    if (draw_below(&random, 4) == 0) draw_point(&random, -1000, 1000, offset);
    const float size =
        ldexpf(1, draw_below(&random, 2) ? 0 : draw_exponent(&random, draw_below(&random, 3) ? 35 : 100));
    for (size_t i = 0; i < 9 * soup.count; i++) {
        soup.corners[i] = (soup.corners[i] + offset[i % 3]) * size;
        if (!isfinite(soup.corners[i])) soup.corners[i] = 0;
    }
    for (int k = 0; k < 3; k++) camera.eye[k] = (camera.eye[k] + offset[k]) * size;
    /* Mostly without limits: with them there are no cells before there are rays. */
    if (draw_below(&random, 8) == 0) {
        const int exponent = draw_exponent(&random, 4);
        camera.t_min = ldexpf(draw_range(&random, 0, 1), exponent) * size * scale;
        if (!isfinite(camera.t_min)) camera.t_min = 0;
        if (draw_below(&random, 2)) camera.t_max = camera.t_min * draw_range(&random, 0.9f, 4);
    }
    check_cells("hostile picture", seed, &soup, &camera);
}

static void hostile_pictures(void **state)
{
    (void)state;
    if (only_seed) {
        check_hostile_picture(only_seed);
        return;
    }
    for (uint64_t seed = 1; seed <= scaled(360 * effort); seed++) check_hostile_picture(seed);
}

/* ---- single cases ------------------------------------------------------------------------------------------------ */

static mlrt_camera straight_camera(uint32_t width, uint32_t height, float field)
{
    mlrt_camera camera = {.struct_size = sizeof camera, .width = width, .height = height};
    camera.sample_x = camera.sample_y = 0.5f;
    camera.dx[0] = field / (float)width;
    camera.dy[1] = field / (float)height;
    camera.d00[0] = camera.d00[1] = -field / 2;
    camera.d00[2] = 1;
    return camera;
}

/* Directions so short that reciprocals of them, or twice these, are infinite. */
static void short_directions(void **state)
{
    (void)state;
    for (int exponent = -149; exponent <= -118; exponent++) {
        for (int half = 0; half < 2; half++) {
            struct soup soup = {0};
            const float corner[3] = {-8, -8, 1}, side[3] = {16, 0, 0}, other[3] = {0, 16, half ? 0.5f : 0};
            soup_add_quad(&soup, corner, side, other);
            mlrt_camera camera = straight_camera(20, 20, 1);
            const float scale = ldexpf(1 + 0.25f * (float)half, exponent);
            for (int k = 0; k < 3; k++) {
                camera.d00[k] *= scale;
                camera.dx[k] *= scale;
                camera.dy[k] *= scale;
            }
            check_cells("short directions", (uint64_t)-exponent, &soup, &camera);
        }
    }
}

/*
 * Slopes that are denormal, of rays whose components are not, and triangles that begin just beside a cell's last ray:
 * what rounding takes of such a slope is no small part of it.
 */
static void denormal_slopes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < scaled(240 * effort); seed++) {
        struct random random = {seed * 0x10001 + 3};
        struct soup soup = {0};
        const float depth = ldexpf(draw_range(&random, 1, 2), 58);
        const double unit = ldexp((double)depth, -149), exponent = (double)draw_range(&random, -2, 7);
        const double edge = exp2(exponent) * (draw_below(&random, 2) ? 1 : -1);
        const double beyond = edge * (1 + (double)draw_range(&random, 0, 1) * exp2(-1 - exponent));
        const float a[3] = {(float)(edge * unit), -depth, depth}, b[3] = {(float)(edge * unit), depth, depth};
        const float c[3] = {(float)(64 * edge * unit), 0, depth};
        soup_add_triangle(&soup, a, b, c);
        mlrt_camera camera = straight_camera(4, 4, 0.5f);
        for (int k = 0; k < 3; k++) {
            camera.d00[k] *= 0x1p60f;
            camera.dy[k] *= 0x1p60f;
        }
        camera.sample_x = 0;
        camera.d00[0] = 0;
        camera.dx[0] = (float)ldexp(beyond / 3, -89);
        const int turns = (int)draw_below(&random, 3), negative = (int)draw_below(&random, 2);
        turn(camera.d00, turns, negative);
        turn(camera.dx, turns, negative);
        turn(camera.dy, turns, negative);
        for (size_t i = 0; i < 3; i++) turn(soup.corners + 3 * i, turns, negative);
        check_cells("denormal slopes", seed, &soup, &camera);
    }
}

/*
 * Rows of triangles that only some of a tile's packets meet, and rays with a component of 0x1p-60 or less, which float
 * does not carry: a packet that is closed when others are given up has not seen all of the scene.
 */
static void tiles_given_up_with_tiny_components(void **state)
{
    (void)state;
    const float corner[3] = {-100, -100, 10}, side[3] = {200, 0, 0.5f}, other[3] = {0, 200, 0};
    for (uint64_t seed = 1; seed <= scaled(40 * effort); seed++) {
        struct random random = {seed * 0x10001 + 5};
        struct soup soup = {0};
        const uint32_t count = 150 + draw_below(&random, 600), rows = 6 + draw_below(&random, 6);
        for (uint32_t i = 0; i < count; i++) {
            const float z = draw_range(&random, 1, 1.3f), y = ((float)draw_below(&random, rows) - 7.5f) * 0.01f * z;
            float p[3][3];
            for (int v = 0; v < 3; v++) {
                p[v][0] = draw_range(&random, -0.08f, 0.08f);
                p[v][1] = y + draw_range(&random, -0.002f, 0.002f);
                p[v][2] = z + draw_range(&random, -0.01f, 0.01f);
            }
            soup_add_triangle(&soup, p[0], p[1], p[2]);
        }
        soup_add_quad(&soup, corner, side, other);
        mlrt_camera camera = {.struct_size = sizeof camera, .width = 16, .height = 16, .d00 = {-0.0625f, -0.08f, 1}};
        camera.dy[1] = 0.01f;
        if (seed % 2) {
            camera.dx[0] = 0x1p-7f;
            camera.dy[0] = 6.1e-20f; /* what rounding leaves of the cosine of a right angle */
        } else {
            camera.dx[0] = 0x1p-50f;
            camera.d00[0] = 0x1p-70f;
        }
        check_cells("tiny components", seed, &soup, &camera);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(short_directions),
        cmocka_unit_test(denormal_slopes),
        cmocka_unit_test(tiles_given_up_with_tiny_components),
        cmocka_unit_test(hostile_pictures),
    };
    if (argc > 1 && atoi(argv[1]) > 0) effort = (size_t)atoi(argv[1]);
    if (argc > 2) only_seed = strtoull(argv[2], NULL, 10);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
