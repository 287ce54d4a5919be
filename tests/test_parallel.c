/* SPDX-License-Identifier: MIT */
/*
 * Rays of one direction: parallel cameras, directional lights and arrays, against the reference.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hostile_rays.h"
#include "support.h"

static void check_traced(const struct fixture *fixture, const struct ray_list *list, const char *text,
                         const struct reference_hit *expected, const struct reference_hit *hits,
                         const uint8_t *occluded)
{
    for (size_t i = 0; i < list->count; ++i) {
        if (hits) check_hit(fixture, text, i, &list->rays[i], &expected[i], &hits[i]);
        if (!occluded || occluded[i] == (expected[i].mesh != MLRT_NONE)) continue;
        print_difference(fixture, text, i, &list->rays[i], &expected[i], &expected[i]);
        fail_msg("occluded: %d", (int)occluded[i]);
    }
}

/* Rays of arrays; or those of a camera, or of a light, if there is one. Closest and any hit, by method tile. */
static void check_by_tiles(const struct fixture *fixture, const struct ray_list *list, const mlrt_camera *camera,
                           const mlrt_light *light)
{
    char text[200];
    struct reference_hit *expected = allocate_or_fail(list->count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    trace_reference(fixture, list, expected);
    const mlrt_hits hits = public_hits(got, camera ? list->row_length : 0);
    const mlrt_hits any = {.struct_size = sizeof any, .occluded = {occluded, 0, 0}};
    const mlrt_rays rays = public_rays(list);
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = list->row_length,
                                .count = list->count,
                                .positions = rays.origins,
                                .skip = rays.skip};
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; ++isa) {
        if (!isa_is_supported(isa)) continue;
        mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_TILE, .isa = isa};
        describe(camera ? "camera" : light ? "light" : "arrays", &options, 0, text, sizeof text);
        memset(occluded, 0xA5, list->count);
        if (light) {
            assert_int_equal(mlrt_occluded_points(fixture->tree, &points, light, &options, &any.occluded), MLRT_OK);
            check_traced(fixture, list, text, expected, NULL, occluded);
            continue;
        }
        memset(got, 0xA5, list->count * sizeof *got);
        for (int32_t query = 0; query < 2; ++query) {
            options.query = query ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST;
            const mlrt_hits *out = query ? &any : &hits;
            assert_int_equal(camera ? mlrt_render_tiles(fixture->tree, camera, &options, out, NULL, NULL)
                                    : mlrt_trace_packet(fixture->tree, &rays, &options, out),
                             MLRT_OK);
        }
        check_traced(fixture, list, text, expected, got, occluded);
    }
    free(expected);
    free(got);
    free(occluded);
}

/* Scenes of small whole coordinates, where much is exactly on edges and in planes. */
#define SCENE_COUNT 7

static struct fixture draw_scene(uint32_t number)
{
    static const char *const names[SCENE_COUNT] = {"whole numbers", "quads", "needles", "soup", "tiny", "flat", "huge"};
    struct random random = {900 + number};
    struct soup soup = {0};
    const float corner[3] = {0, 0, 0}, lo[3] = {-1, -1, -1}, hi[3] = {5, 5, 5};
    switch (number) {
    case 1:
        for (int axis = 0; axis < 3; ++axis) soup_add_grid(&soup, axis, (float)axis, 3);
        soup_add_box(&soup, lo, hi);
        break;
    case 2:
        soup_add_needles(&soup, &random, 60, 0x1p-20f);
        break;
    case 3:
        soup_add_random(&soup, &random, 60, 2, 0.5f);
        break;
    case 5:
        soup_add_grid(&soup, 2, 1, 4);
        break;
    default:
        for (int i = 0; i < 60; ++i) {
            float v[3][3];
            for (int j = 0; j < 9; ++j) v[j / 3][j % 3] = (float)draw_below(&random, 5);
            soup_add_triangle(&soup, v[0], v[1], v[2]);
        }
    }
    if (number == 4) move_soup(&soup, 0x1p-57f, corner);
    if (number == 6) move_soup(&soup, 0x1p50f, corner);
    return fixture_of_soup(names[number], 900 + number, &soup);
}

static const float *draw_scene_corner(struct random *random, const struct fixture *fixture)
{
    const size_t count = reference_triangle_count(fixture->reference);
    return reference_triangle_at(fixture->reference, draw_below(random, (uint32_t)count))
        ->corner[draw_below(random, 3)];
}

/* Along axes and diagonals, from vertex to vertex, in planes of triangles, any; short, long, and of unequal parts. */
static void draw_common_direction(struct random *random, const struct fixture *fixture, float direction[3])
{
    const uint32_t kind = draw_below(random, 6);
    const float *from = draw_scene_corner(random, fixture), *to = draw_scene_corner(random, fixture);
    const float length = draw_below(random, 4) ? 1 : ldexpf(1, (int)draw_below(random, 100) - 50);
    for (int k = 0; k < 3; ++k) {
        direction[k] = kind == 1   ? (float)((int)draw_below(random, 5) - 2)
                       : kind == 2 ? to[k] - from[k]
                                   : draw_range(random, -1, 1);
        if (kind == 3) direction[k] *= ldexpf(1, -(int)draw_below(random, 30));
        if (kind == 0) direction[k] = draw_below(random, 2) ? 0.0f : -0.0f;
        direction[k] *= kind == 2 ? 1 : length;
    }
    if (kind == 0 || (direction[0] == 0 && direction[1] == 0 && direction[2] == 0)) {
        direction[draw_below(random, 3)] = draw_below(random, 2) ? length : -length;
    }
}

static float extent_of(const struct fixture *fixture, float lo[3], float hi[3])
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_get_tree_info(fixture->tree, &info), MLRT_OK);
    float extent = 0;
    for (int k = 0; k < 3; ++k) {
        lo[k] = info.bounds_min[k];
        hi[k] = info.bounds_max[k];
        extent = fmaxf(extent, hi[k] - lo[k]);
    }
    return extent;
}

static float largest_of(const float v[3])
{
    return fmaxf(fabsf(v[0]), fmaxf(fabsf(v[1]), fabsf(v[2])));
}

/* A vertex, a corner of the scene's box, a middle of an edge, or any point. */
static void draw_place(struct random *random, const struct fixture *fixture, float point[3])
{
    float lo[3], hi[3];
    const float *a = draw_scene_corner(random, fixture), *b = draw_scene_corner(random, fixture);
    const uint32_t kind = draw_below(random, 4);
    (void)extent_of(fixture, lo, hi);
    for (int k = 0; k < 3; ++k) {
        point[k] = kind == 0   ? a[k]
                   : kind == 1 ? 0.5f * a[k] + 0.5f * b[k]
                   : kind == 2 ? (draw_below(random, 2) ? lo[k] : hi[k])
                               : draw_range(random, lo[k], hi[k]);
    }
}

/*
 * A picture of origins, `width` wide, of which some rows or columns may lie elsewhere, and which may begin before,
 * within or behind the scene; or places all over it.
 */
static void add_origins(struct random *random, const struct fixture *fixture, size_t count, uint32_t width,
                        const float direction[3], struct ray_list *list)
{
    float lo[3], hi[3], base[3], across[3], down[3];
    const float extent = extent_of(fixture, lo, hi), back = draw_below(random, 3) ? draw_range(random, 0, 2) : 0;
    const float step = ldexpf(extent, -(int)draw_below(random, 12)), away = back * (extent / largest_of(direction));
    const int is_scattered = draw_below(random, 4) == 0, is_whole = (int)draw_below(random, 2);
    const float jump = draw_below(random, 3) ? 0 : 0.3f * extent;
    const int axis = (int)draw_below(random, 3);
    draw_place(random, fixture, base);
    for (int k = 0; k < 3; ++k) {
        across[k] = is_whole ? (k == axis ? step : 0) : step * draw_range(random, -1, 1);
        down[k] = is_whole ? (k == (axis + 1) % 3 ? step : 0) : step * draw_range(random, -1, 1);
    }
    for (size_t i = 0; i < count; ++i) {
        const float x = (float)(i % width), y = (float)(i / width);
        float origin[3];
        if (is_scattered) draw_place(random, fixture, base);
        const float beside = (i % width / 6 + i / width / 5) % 2 ? jump : 0;
        for (int k = 0; k < 3; ++k) {
            origin[k] = base[k] + beside - away * direction[k] + (is_scattered ? 0 : x * across[k] + y * down[k]);
        }
        add_ray(list, origin, direction);
    }
}

/* Ranges that end at hits, or beside them, and skips of what would be hit. */
static void add_ranges(struct random *random, const struct fixture *fixture, struct ray_list *list)
{
    const uint32_t kind = draw_below(random, 4), has_skips = draw_below(random, 2);
    float lo[3], hi[3];
    const float whole = extent_of(fixture, lo, hi) / largest_of(list->rays[0].direction);
    const float least = whole * draw_range(random, 0, 1), greatest = whole * draw_range(random, 0, 2);
    for (size_t i = 0; i < list->count; ++i) {
        struct reference_ray *ray = &list->rays[i];
        struct reference_hit hit;
        reference_trace(fixture->reference, ray, &hit);
        if (has_skips && draw_below(random, 3)) {
            ray->skip[0] = hit.mesh;
            ray->skip[1] = hit.triangle;
        }
        const float t = hit.mesh == MLRT_NONE ? whole : next_float(hit.t, (int)draw_below(random, 3) - 1);
        if (kind == 1) ray->t_min = draw_below(random, 2) ? fmaxf(t, 0) : least * draw_range(random, 0, 1);
        if (kind == 2) ray->t_max = draw_below(random, 2) ? t : greatest * draw_range(random, 0, 1);
        if (kind == 3) ray->t_min = least, ray->t_max = greatest;
    }
}

static void arrays_of_one_direction(void **state)
{
    (void)state;
    struct random random = {31};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(70); ++round) {
            struct ray_list list = {0};
            float direction[3];
            draw_common_direction(&random, &fixture, direction);
            list.row_length = draw_below(&random, 3) ? 4 + draw_below(&random, 40) : 0;
            const size_t count = 1 + draw_below(&random, 500);
            add_origins(&random, &fixture, count, list.row_length ? list.row_length : 4, direction, &list);
            if (draw_below(&random, 2)) add_ranges(&random, &fixture, &list);
            check_by_tiles(&fixture, &list, NULL, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* Packets of one direction beside those of others, and of the opposite one; and packets of several. */
static void several_directions_in_one_tile(void **state)
{
    (void)state;
    struct random random = {32};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(40); ++round) {
            struct ray_list list = {.row_length = 16 + 4 * draw_below(&random, 8)};
            float directions[3][3];
            const uint32_t block = draw_below(&random, 6) ? 4 : 3;
            for (int i = 0; i < 3; ++i) draw_common_direction(&random, &fixture, directions[i]);
            if (draw_below(&random, 2)) {
                for (int k = 0; k < 3; ++k) directions[1][k] = -directions[0][k];
            }
            add_origins(&random, &fixture, 600, list.row_length, directions[0], &list);
            for (size_t i = 0; i < list.count; ++i) {
                const size_t x = i % list.row_length / block, y = i / list.row_length / block;
                memcpy(list.rays[i].direction, directions[(x + y) % 3], sizeof directions[0]);
            }
            if (draw_below(&random, 2)) add_ranges(&random, &fixture, &list);
            check_by_tiles(&fixture, &list, NULL, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

static void directional_lights(void **state)
{
    (void)state;
    struct random random = {33};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(60); ++round) {
            struct ray_list list = {.row_length = draw_below(&random, 3) ? 20 + draw_below(&random, 40) : 0};
            mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_DIRECTIONAL};
            draw_common_direction(&random, &fixture, light.position);
            add_origins(&random, &fixture, 800, list.row_length ? list.row_length : 4, light.position, &list);
            for (size_t i = 0; i < list.count && round % 2; ++i) {
                struct reference_hit hit;
                reference_trace(fixture.reference, &list.rays[i], &hit);
                list.rays[i].skip[0] = hit.mesh;
                list.rays[i].skip[1] = hit.triangle;
            }
            check_by_tiles(&fixture, &list, NULL, &light);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* In front of the scene, within it and behind it; square to the direction, or oblique; with limits, too. */
static void parallel_cameras(void **state)
{
    (void)state;
    struct random random = {34};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(30); ++round) {
            float lo[3], hi[3], direction[3], middle[3];
            const float extent = extent_of(&fixture, lo, hi);
            draw_common_direction(&random, &fixture, direction);
            draw_place(&random, &fixture, middle);
            const float back = draw_below(&random, 4) ? draw_range(&random, 0, 4) : -0.5f;
            const float away = back * (extent / largest_of(direction));
            for (int k = 0; k < 3; ++k) middle[k] -= away * direction[k];
            const float width = ldexpf(extent, 1 - (int)draw_below(&random, 8));
            const uint32_t columns = 1 + draw_below(&random, 70), rows = 1 + draw_below(&random, 40);
            mlrt_camera camera = look_along(middle, direction, width, columns, rows);
            if (draw_below(&random, 2)) { /* along axes, and so oblique to the direction */
                const float step = width / (float)columns;
                int a = 0;
                for (int k = 1; k < 3; ++k) a = fabsf(direction[k]) > fabsf(direction[a]) ? k : a;
                for (int k = 0; k < 3; ++k) {
                    camera.dx[k] = k == (a + 1) % 3 ? step : 0;
                    camera.dy[k] = k == (a + 2) % 3 ? step : 0;
                    camera.d00[k] =
                        middle[k] - 0.5f * (float)columns * camera.dx[k] - 0.5f * (float)rows * camera.dy[k];
                }
                camera.sample_x = camera.sample_y = 0;
            }
            if (round % 4 == 3) camera.t_min = away > 0 ? away : 0;
            if (round % 5 == 4) camera.t_max = fabsf(away) * 1.25f;
            struct ray_list list = {0};
            const mlrt_array none = {NULL, 0, 0};
            if (mlrt_camera_rays(&camera, &none, &none) != MLRT_OK) continue; /* dx and dy underflow */
            add_camera_rays(&list, &camera);
            check_by_tiles(&fixture, &list, &camera, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* Packets so wide that they are no cells, with directions that are short, or nearly 1. */
static void small_pictures(void **state)
{
    (void)state;
    static const float lengths[] = {0x1p-20f, 0x1p-9f, 0.4375f, 0.9375f, 3};
    for (uint32_t number = 0; number < 2; ++number) {
        struct fixture fixture = draw_scene(number);
        for (uint32_t i = 0; i < 5 * 9; ++i) {
            const uint32_t size = 1 + i / 5;
            const float step = 4 / (float)size, slant = i % 2 ? 0.25f * lengths[i % 5] : 0;
            mlrt_camera camera = {.struct_size = sizeof camera,
                                  .width = size,
                                  .height = size,
                                  .projection = MLRT_PROJECTION_PARALLEL,
                                  .direction = {slant, 0, -lengths[i % 5]},
                                  .d00 = {0, 0, 5.5f},
                                  .dx = {step, 0, 0},
                                  .dy = {0, step, 0},
                                  .sample_x = 0.5f,
                                  .sample_y = 0.5f};
            struct ray_list list = {0};
            add_camera_rays(&list, &camera);
            check_by_tiles(&fixture, &list, &camera, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_of_one_direction), cmocka_unit_test(several_directions_in_one_tile),
        cmocka_unit_test(directional_lights),      cmocka_unit_test(parallel_cameras),
        cmocka_unit_test(small_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
