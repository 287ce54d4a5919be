/* SPDX-License-Identifier: MIT */
/*
 * Scenes anywhere among the floats, and few triangles that lie elsewhere than the others: the answers are right by
 * every way of tracing, and by counts no ray pays for what it does not meet.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/tree.h"
#include "support.h"

/* Odd triangles, relative to a scene in [-1, 1]^3. */
static const struct {
    const char *name;
    float corners[9];
} odd_triangles[] = {
    {"a wall behind all", {-0x1p70f, -0x1p70f, 3, 0x1p70f, -0x1p70f, 3, 0, 0x1p71f, 3}},
    {"a wall before all", {-0x1p70f, -0x1p70f, -3, 0x1p70f, -0x1p70f, -3, 0, 0x1p71f, -3}},
    {"a slanted wall", {-0x1p65f, -0x1p66f, -0x1p64f, 0x1p65f, -0x1p66f, 0x1p65f, 0, 0x1p66f, 3}},
    {"one far corner", {-0.5f, -0.5f, 0.25f, 0.5f, -0.5f, 0.5f, 0.5f, 0x1p100f, 0.125f}},
    {"a needle through all", {-0x1p90f, 0.1f, 0, 0x1p90f, 0.125f, 0.1f, 0x1p90f, 0.15f, 0}},
    {"far away", {0x1p70f, -0x1p70f, 0x1p70f, 0x1p70f, 0x1p70f, 0x1p70f, 0x1p70f, 0, 0x1p71f}},
    {"at the end of floats", {-FLT_MAX, -FLT_MAX, FLT_MAX / 2, FLT_MAX, -FLT_MAX, FLT_MAX / 2, 0, FLT_MAX, FLT_MAX}},
    {"a tiny one", {0, 0, 0, 0x1p-70f, 0, 0, 0, 0x1p-70f, 0x1p-71f}},
    {"a tiny one beside a corner", {0.5f, 0, 0, 0.5f, 0x1p-100f, 0, 0.5f, 0, 0x1p-120f}},
};

#define ODD_COUNT (sizeof odd_triangles / sizeof odd_triangles[0])

static void add_odd_triangle(struct soup *soup, size_t odd)
{
    const float *c = odd_triangles[odd].corners;
    soup_add_triangle(soup, c, c + 3, c + 6);
}

static struct soup draw_scene(struct random *random, size_t count)
{
    struct soup soup = {0};
    soup_add_random(&soup, random, count / 2, 1, 0.3f);
    soup_add_random(&soup, random, count / 2, 1, 0.05f);
    return soup;
}

static void scale_soup(struct soup *soup, int power)
{
    for (size_t i = 0; i < 9 * soup->count; i++) soup->corners[i] = ldexpf(soup->corners[i], power);
}

/* Scales what a camera sees, and its directions. */
static mlrt_camera scale_camera(mlrt_camera camera, int power, int direction_power)
{
    const int is_parallel = camera.projection == MLRT_PROJECTION_PARALLEL;
    const int p_power = is_parallel ? power : direction_power;
    for (int k = 0; k < 3; k++) {
        camera.eye[k] = ldexpf(camera.eye[k], power);
        camera.direction[k] = ldexpf(camera.direction[k], direction_power);
        camera.d00[k] = ldexpf(camera.d00[k], p_power);
        camera.dx[k] = ldexpf(camera.dx[k], p_power);
        camera.dy[k] = ldexpf(camera.dy[k], p_power);
    }
    return camera;
}

static void check_cameras(const struct fixture *fixture, struct random *random, int power, int direction_power)
{
    const float centre[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        float eye[3], direction[3];
        draw_point(random, -3, 3, eye);
        for (int k = 0; k < 3; k++) direction[k] = -eye[k];
        if (i == 0) eye[0] = eye[1] = 0, eye[2] = -3;
        mlrt_camera camera = scale_camera(look_at(eye, centre, 1.5f, 24, 16), power, direction_power);
        check_camera_quickly(fixture, &camera);
        camera = scale_camera(look_along(centre, direction, 3, 16, 16), power, direction_power);
        check_camera_quickly(fixture, &camera);
    }
}

/* Rays of a scene in [-1, 1]^3, scaled. */
static void add_scaled_rays(struct ray_list *list, struct random *random, const struct fixture *at_one, int power,
                            int direction_power)
{
    add_mixed_rays(list, random, at_one, scaled(100), -2, 2);
    for (size_t i = 0; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        for (int k = 0; k < 3; k++) {
            ray->origin[k] = ldexpf(ray->origin[k], power);
            ray->direction[k] = ldexpf(ray->direction[k], direction_power);
        }
        ray->t_min = ldexpf(ray->t_min, power - direction_power);
        ray->t_max = ldexpf(ray->t_max, power - direction_power);
    }
}

static void check_scene(const char *name, uint64_t seed, const struct soup *scene, int power, int direction_power,
                        int has_odd, size_t odd)
{
    struct random random = {seed};
    struct soup soup = {0}, copy = {0};
    for (size_t i = 0; i < scene->count; i++) {
        const float *c = scene->corners + 9 * i;
        soup_add_triangle(&soup, c, c + 3, c + 6);
        soup_add_triangle(&copy, c, c + 3, c + 6);
    }
    if (has_odd) add_odd_triangle(&soup, odd);
    scale_soup(&soup, power);
    struct fixture at_one = fixture_of_soup(name, seed, &copy), fixture = fixture_of_soup(name, seed, &soup);
    struct ray_list list = {0};
    add_scaled_rays(&list, &random, &at_one, power, direction_power);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    check_cameras(&fixture, &random, power, direction_power);
    free_fixture(&fixture);
    free_fixture(&at_one);
}

static void test_scales(void **state)
{
    (void)state;
    static const int powers[] = {-140, -120, -100, -62, -40, -21, 21, 40, 62, 100, 120, 125};
    for (size_t i = 0; i < sizeof powers / sizeof powers[0]; i++) {
        struct random random = {i + 1};
        struct soup scene = draw_scene(&random, 60);
        char name[64];
        snprintf(name, sizeof name, "a scene times 2^%d", powers[i]);
        check_scene(name, i, &scene, powers[i], 0, 0, 0);
        check_scene(name, i, &scene, powers[i], powers[i] / 2, 0, 0);
        check_scene(name, i, &scene, powers[i], powers[i] > 120 ? 120 : powers[i] < -100 ? -100 : powers[i], 0, 0);
        free_soup(&scene);
    }
}

static void test_odd_triangles(void **state)
{
    (void)state;
    static const int powers[] = {0, 0, -50, 50};
    for (size_t odd = 0; odd < ODD_COUNT; odd++) {
        for (size_t i = 0; i < scaled(4); i++) {
            struct random random = {odd + 1};
            struct soup scene = draw_scene(&random, i == 1 ? 20 : 60);
            char name[96];
            const int power = odd == 6 && powers[i] > 0 ? 0 : powers[i];
            snprintf(name, sizeof name, "%s, all times 2^%d", odd_triangles[odd].name, power);
            check_scene(name, odd, &scene, power, 0, 1, odd);
            if (power) check_scene(name, odd, &scene, power, power, 1, odd);
            free_soup(&scene);
        }
    }
}

/*
 * Triangles a few floats beside an odd one, so that double or the judge has to say which a ray meets first. Leaves have
 * NaNs for the corners of the odd one.
 */
static void odd_triangles_have_close_neighbours(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 16; seed++) {
        struct random random = {seed};
        const float slope = seed % 3 ? 0 : 0.25f;
        const float wall[3][3] = {{0, 0, 1}, {0x1p61f, 0, 1 + slope * 0x1p61f}, {0, 0x1p61f, 1}};
        struct soup soup = {0};
        struct ray_list list = {0};
        if (seed % 2) soup_add_triangle(&soup, wall[0], wall[1], wall[2]);
        for (int i = 0; i < 24; i++) {
            float corners[3][3];
            for (int j = 0; j < 3; j++) {
                draw_point(&random, 0, 1, corners[j]);
                corners[j][2] = 1 + slope * corners[j][0] + 0x1p-23f * (float)draw_below(&random, 4) - 0x1p-23f;
            }
            soup_add_triangle(&soup, corners[0], corners[1], corners[2]);
        }
        if (!(seed % 2)) soup_add_triangle(&soup, wall[0], wall[1], wall[2]);
        struct fixture fixture = fixture_of_soup("close to an odd triangle", seed, &soup);
        add_aimed_rays(&list, &random, &fixture, scaled(60), -1, 1);
        add_random_rays(&list, &random, scaled(60), 0, 1);
        for (size_t i = 0; i < scaled(120); i++) {
            float from[3], to[3];
            draw_point(&random, 0, 1, from);
            draw_point(&random, 0, 1, to);
            to[2] = 1 + slope * to[0];
            add_ray_towards(&list, from, to);
        }
        check_rays(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/*
 * Checks rays in a scene of 40 triangles within +-size, and some more, all times 2^power, so that the unit is not 1.
 * Frees the rays.
 */
static void check_in_units(uint64_t seed, float size, const float (*more)[3][3], size_t more_count, int power,
                           struct ray_list *list)
{
    struct random random = {seed};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, size, size / 4);
    for (size_t i = 0; i < more_count; i++) soup_add_triangle(&soup, more[i][0], more[i][1], more[i][2]);
    for (size_t i = 0; i < 9 * soup.count; i++) soup.corners[i] = ldexpf(soup.corners[i], power);
    struct fixture fixture = fixture_of_soup("in units", seed, &soup);
    assert_true(fixture.tree->bvh.unit != 1);
    check_rays(&fixture, list);
    free_rays(list);
    free_fixture(&fixture);
}

/*
 * Hits whose t is about the least normal float in units, where floats below it lie as far apart as those above, and
 * half as far apart as given. The plane z + s x = 2^-126, of a triangle at the origin, is met at 2^-126 / (1 + s / 4096).
 */
static void distances_about_the_least_normal_float(void **state)
{
    (void)state;
    for (int eighths = 1; eighths <= 24; eighths++) {
        struct ray_list list = {0};
        const float s = ldexpf((float)eighths, -15), size = 0x1p-113f, z = 0x1p-126f;
        const float tiny[1][3][3] = {{{-size, -size, z + s * size}, {size, -size, z - s * size}, {0, 2 * size, z}}};
        for (int sign = -1; sign <= 1; sign++) {
            const float origin[3] = {0, 0, 0}, direction[3] = {(float)sign * 0x1p-12f, 0, 1};
            add_ray(&list, origin, direction);
        }
        check_in_units((uint64_t)eighths, 1, tiny, 1, 57, &list);
    }
}

/*
 * Hits whose t as given is about the least normal float, below which floats lie as far apart as above: but in units
 * they lie half as far apart there. The ray (0, 0, s 2^126) meets the plane z = s - i ulp at 2^-126 (1 - i ulp / s).
 * The scene is large beside s, so that the powers of rays are normal floats.
 */
static void given_distances_about_the_least_normal_float(void **state)
{
    (void)state;
    enum { POWER = -31 };
    for (int eighths = 8; eighths < 16; eighths++) {
        for (int i = -4; i <= 12; i++) {
            struct ray_list list = {0};
            const float s = (float)eighths / 8, z = s - (float)i * 0x1p-23f;
            const float wall[1][3][3] = {{{-1, -1, z}, {3, -1, z}, {-1, 3, z}}};
            const float origin[3] = {0, 0, 0}, direction[3] = {0, 0, ldexpf(s, 126 + POWER)};
            add_ray(&list, origin, direction);
            check_in_units((uint64_t)(16 * eighths + i), 16, wall, 1, POWER, &list);
        }
    }
}

/*
 * Rays from origins with a component that is not 0 as given, but would be in units. In units two triangles at
 * z = 3 * 2^-127 are 2^-149 / 3 + x apart where y = 0: which comes first depends on that component.
 */
static void origins_that_underflow_in_units(void **state)
{
    (void)state;
    const float s = 0x1p-128f, z = 3 * 0x1p-127f;
    const float pairs[3][3][3] = {{{-s, -s, z}, {s, -s, z}, {0, 2 * s, z}},
                                  {{-s, -s, z - s}, {s, -s, z + s}, {0, 2 * s, z + 0x1p-149f}},
                                  {{-s, -s, z}, {s, -s, z}, {0, 2 * s, z}}};
    for (size_t first = 0; first < 2; first++) {
        struct ray_list list = {0};
        for (int sign = -1; sign <= 1; sign++) {
            const float origin[3] = {(float)sign * 0x1p-93f, 0, 0}, direction[3] = {0, 0, 1};
            add_ray(&list, origin, direction);
        }
        check_in_units(first + 1, 1, pairs + first, 2, 57, &list);
    }
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

static mlrt_counters count_rays(const struct fixture *fixture, const struct ray_list *list, int32_t query)
{
    mlrt_counters counters = {.struct_size = sizeof counters};
    const mlrt_trace_options options = {.struct_size = sizeof options, .query = query, .counters = &counters};
    struct reference_hit *hits = allocate_or_fail(list->count, sizeof *hits);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    const mlrt_rays rays = public_rays(list);
    mlrt_hits results = public_hits(hits, 0);
    if (query == MLRT_QUERY_ANY) {
        const mlrt_hits only_occluded = {.struct_size = sizeof results, .occluded = {occluded, 1}};
        results = only_occluded;
    }
    assert_int_equal(mlrt_trace_packet(fixture->tree, &rays, &options, &results), MLRT_OK);
    free(occluded);
    free(hits);
    return counters;
}

static mlrt_counters count_camera(const struct fixture *fixture, const mlrt_camera *camera)
{
    mlrt_counters counters = {.struct_size = sizeof counters};
    const mlrt_trace_options options = {.struct_size = sizeof options, .counters = &counters};
    const size_t count = (size_t)camera->width * camera->height;
    struct reference_hit *hits = allocate_or_fail(count, sizeof *hits);
    const mlrt_hits results = public_hits(hits, 0);
    assert_int_equal(mlrt_render_tiles(fixture->tree, camera, &options, &results, NULL, NULL), MLRT_OK);
    free(hits);
    return counters;
}

static void add_views(struct ray_list *list, struct random *random)
{
    const float eye[3] = {0.25f, 0.5f, -3}, centre[3] = {0, 0, 0};
    const mlrt_camera camera = look_at(eye, centre, 1.5f, 64, 64);
    add_camera_rays(list, &camera);
    list->row_length = 64;
    add_random_rays(list, random, 64 * 16, -2, 2);
}

static void assert_no_more(const char *name, const char *what, uint64_t expected, uint64_t got, uint64_t extra)
{
    if ((double)got > 1.05 * (double)expected + (double)extra)
        fail_msg("%s: %s %llu, without %llu", name, what, (unsigned long long)got, (unsigned long long)expected);
}

/*
 * Odd triangles farther away than bundles keep distances (GREATEST_DISTANCE, trace/ray_terms.h): the judge has all
 * hits.
 */
#define AT_THE_END 6

/*
 * Rays go together as without the odd triangle, boxes are no worse, and few rays are left to the judge. The hierarchy
 * is another one: of a camera's rays, more or fewer go on alone where few meet a box. Each is a packet then, and has
 * nodes of its own. Each packet of a camera may meet the odd triangle.
 */
static void test_odd_triangles_stay_local(void **state)
{
    (void)state;
    struct random random = {77};
    struct soup scene = draw_scene(&random, 4000), copy = {0};
    for (size_t i = 0; i < scene.count; i++)
        soup_add_triangle(&copy, scene.corners + 9 * i, scene.corners + 9 * i + 3, scene.corners + 9 * i + 6);
    struct fixture without = fixture_of_soup("without", 77, &copy);
    const float eye[3] = {0.25f, 0.5f, -4}, centre[3] = {0, 0, 0};
    const mlrt_camera camera = look_at(eye, centre, 0.75f, 128, 128);
    for (size_t odd = 0; odd < ODD_COUNT; odd++) {
        struct soup soup = {0};
        const char *name = odd_triangles[odd].name;
        for (size_t i = 0; i < scene.count; i++)
            soup_add_triangle(&soup, scene.corners + 9 * i, scene.corners + 9 * i + 3, scene.corners + 9 * i + 6);
        add_odd_triangle(&soup, odd);
        struct fixture with = fixture_of_soup(name, 77, &soup);
        struct ray_list list = {0};
        random.state = 5;
        add_views(&list, &random);
        const mlrt_counters a = count_rays(&without, &list, MLRT_QUERY_CLOSEST);
        const mlrt_counters b = count_rays(&with, &list, MLRT_QUERY_CLOSEST);
        const mlrt_counters c = count_camera(&without, &camera), d = count_camera(&with, &camera);
        assert_no_more(name, "packets", a.packet_count, b.packet_count, a.packet_count / 10);
        assert_no_more(name, "cells", a.cell_count, b.cell_count, a.cell_count / 10);
        assert_no_more(name, "tests", a.triangle_test_count, b.triangle_test_count, a.triangle_test_count / 10);
        assert_no_more(name, "judged lanes", a.judged_lane_count, b.judged_lane_count, list.count);
        assert_no_more(name, "packets of a camera", c.packet_count, d.packet_count, 128 * 128 / 32);
        assert_no_more(name, "cells of a camera", c.cell_count, d.cell_count, c.cell_count / 4);
        assert_no_more(name, "tests of a camera", c.triangle_test_count, d.triangle_test_count,
                       128 * 128 / 16 + c.triangle_test_count / 16);
        assert_no_more(name, "judged lanes of a camera", c.judged_lane_count, d.judged_lane_count,
                       odd == AT_THE_END ? 128 * 128 / 4 : 200);
        free_rays(&list);
        free_fixture(&with);
    }
    free_fixture(&without);
    free_soup(&scene);
}

/* In its own units a scene is the same at every scale: so are the tree and all counts. */
static void test_scales_have_one_tree(void **state)
{
    (void)state;
    static const int powers[] = {-100, -70, 70, 100};
    struct random random = {99};
    struct soup scene = draw_scene(&random, 3000), copy = {0};
    for (size_t i = 0; i < scene.count; i++)
        soup_add_triangle(&copy, scene.corners + 9 * i, scene.corners + 9 * i + 3, scene.corners + 9 * i + 6);
    struct fixture at_one = fixture_of_soup("at one", 99, &copy);
    struct ray_list list = {0};
    add_views(&list, &random);
    const mlrt_counters a = count_rays(&at_one, &list, MLRT_QUERY_CLOSEST);
    const float eye[3] = {0.25f, 0.5f, -3}, centre[3] = {0, 0, 0};
    const mlrt_camera camera = look_at(eye, centre, 1.5f, 128, 128);
    const mlrt_counters c = count_camera(&at_one, &camera);
    for (size_t i = 0; i < sizeof powers / sizeof powers[0]; i++) {
        for (int scales_directions = 0; scales_directions < 2; scales_directions++) {
            struct soup soup = {0};
            for (size_t n = 0; n < scene.count; n++)
                soup_add_triangle(&soup, scene.corners + 9 * n, scene.corners + 9 * n + 3, scene.corners + 9 * n + 6);
            scale_soup(&soup, powers[i]);
            struct fixture fixture = fixture_of_soup("scaled", 99, &soup);
            struct ray_list scaled_list = {0};
            for (size_t n = 0; n < list.count; n++) {
                float origin[3], direction[3];
                for (int k = 0; k < 3; k++) {
                    origin[k] = ldexpf(list.rays[n].origin[k], powers[i]);
                    direction[k] = ldexpf(list.rays[n].direction[k], scales_directions ? powers[i] : 0);
                }
                add_ray(&scaled_list, origin, direction);
            }
            scaled_list.row_length = list.row_length;
            const mlrt_counters b = count_rays(&fixture, &scaled_list, MLRT_QUERY_CLOSEST);
            assert_no_more("scaled", "packets", a.packet_count, b.packet_count, 0);
            assert_no_more("scaled", "cells", a.cell_count, b.cell_count, 0);
            assert_no_more("scaled", "tests", a.triangle_test_count, b.triangle_test_count, 0);
            assert_no_more("scaled", "judged lanes", a.judged_lane_count, b.judged_lane_count, 10);
            const mlrt_camera scaled_camera = scale_camera(camera, powers[i], scales_directions ? powers[i] : 0);
            const mlrt_counters d = count_camera(&fixture, &scaled_camera);
            assert_no_more("scaled", "packets of a camera", c.packet_count, d.packet_count, 0);
            assert_no_more("scaled", "cells of a camera", c.cell_count, d.cell_count, 0);
            assert_no_more("scaled", "tests of a camera", c.triangle_test_count, d.triangle_test_count, 0);
            assert_no_more("scaled", "judged lanes of a camera", c.judged_lane_count, d.judged_lane_count, 10);
            free_rays(&scaled_list);
            free_fixture(&fixture);
        }
    }
    free_rays(&list);
    free_fixture(&at_one);
    free_soup(&scene);
}

/* Rays toward vertices of a scene in [-1, 1]^3: from one point or, if `spread`, from others near it. */
static void add_far_rays(struct ray_list *list, struct random *random, const struct soup *scene, const float from[3],
                         float spread, int count)
{
    for (int i = 0; i < count; ++i) {
        const float *target = scene->corners + 9 * (size_t)draw_below(random, (uint32_t)scene->count);
        float origin[3];
        for (int k = 0; k < 3; ++k) origin[k] = from[k] + spread * draw_range(random, -1, 1);
        add_ray_towards(list, origin, target);
    }
}

/* Counts of each way to have rays from `from`, where all of them go toward the scene. */
static mlrt_counters count_from(const struct fixture *fixture, const struct soup *scene, const float from[3], int way)
{
    static const float centre[3] = {0, 0, 0};
    struct random random = {77};
    struct ray_list list = {0};
    const float distance = sqrtf(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
    const mlrt_camera camera = look_at(from, centre, 1.5f / distance, 16, 16);
    mlrt_counters counters = {.struct_size = sizeof counters};
    if (way == 3) return count_camera(fixture, &camera);
    if (way == 4) {
        float points[256][3];
        uint8_t occluded[256];
        for (int i = 0; i < 256; ++i)
            memcpy(points[i], scene->corners + 9 * (size_t)draw_below(&random, (uint32_t)scene->count), 12);
        const mlrt_trace_options options = {.struct_size = sizeof options, .counters = &counters};
        const mlrt_points list_of = {.struct_size = sizeof list_of, .count = 256, .positions = {points, 0}};
        mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT};
        memcpy(light.position, from, sizeof light.position);
        assert_int_equal(mlrt_occluded_points(fixture->tree, &list_of, &light, &options, &(mlrt_array){occluded, 0, 0}),
                         MLRT_OK);
        return counters;
    }
    add_far_rays(&list, &random, scene, from, way == 1 ? 0.25f * distance : 0, 256);
    counters = count_rays(fixture, &list, way == 2 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST);
    free_rays(&list);
    return counters;
}

/* Does a kd-tree test a ray from `from` against at most 32 triangles in the mean, however it comes to be? */
static void check_tests_of_kdtree(const struct fixture *fixture, const struct soup *scene, const float from[3])
{
    const struct fixture of_kdtree = {.tree = fixture->kdtree};
    for (int way = 0; way < 5; ++way) {
        const uint64_t tests = count_from(&of_kdtree, scene, from, way).triangle_test_count;
        if (tests > 32 * 256) fail_msg("from %g, way %d: %.0f tests of 256 rays", (double)from[1], way, (double)tests);
    }
}

/*
 * Rays from so far away that floats no longer tell the boxes of a scene apart (scene/reach.h) are not tested against
 * all of it, and their answers are right.
 */
static void test_far_origins(void **state)
{
    (void)state;
    static const float distances[] = {0x1p7f, 0x1p12f, 0x1p16f, 0x1p20f, 0x1p40f};
    struct random random = {991};
    struct soup scene = draw_scene(&random, 800), copy = {0};
    for (size_t i = 0; i < scene.count; ++i) {
        const float *c = scene.corners + 9 * i;
        soup_add_triangle(&copy, c, c + 3, c + 6);
    }
    struct fixture fixture = fixture_of_soup("far away", 991, &copy);
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; ++i) {
        const float from[3] = {0.48f * distances[i], -0.8f * distances[i], 0.36f * distances[i]};
        for (int way = 0; way < 5; ++way) {
            const mlrt_counters counters = count_from(&fixture, &scene, from, way);
            if (counters.judged_lane_count > 256 * 8) {
                fail_msg("distance %g, way %d: %.0f close calls of a ray", (double)distances[i], way,
                         (double)counters.judged_lane_count / 256);
            }
        }
        check_tests_of_kdtree(&fixture, &scene, from);
        struct ray_list list = {0};
        add_far_rays(&list, &random, &scene, from, 0, 32);
        add_far_rays(&list, &random, &scene, from, 0.25f * distances[i], 32);
        add_random_rays(&list, &random, 16, -1, 1);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
    }
    free_fixture(&fixture);
    free_soup(&scene);
}

/*
 * A triangle a million times larger than the others makes groups wide beside these, and lets their rays come from where
 * float does not tell them apart. Such groups give up, and their answers are right.
 */
static void groups_give_up(void **state)
{
    (void)state;
    static const float distances[] = {0x1p10f, 0x1p20f, 0x1p26f};
    static const float size = 0x1p20f;
    const mlrt_kdtree_options build = {.struct_size = sizeof build, .rules_off = MLRT_RULE_MINIMUM_CELL};
    struct random random = {993};
    struct soup scene = draw_scene(&random, 3000), all = {0};
    for (size_t i = 0; i < scene.count; ++i) {
        const float *c = scene.corners + 9 * i;
        soup_add_triangle(&all, c, c + 3, c + 6);
    }
    soup_add_triangle(&all, (float[3]){-size, 8, -size}, (float[3]){size, 8, -size}, (float[3]){0, 8, size});
    const mlrt_mesh mesh = soup_mesh(&all);
    struct fixture fixture = {.name = "groups"};
    assert_int_equal(mlrt_build_kdtree(&mesh, 1, &build, &fixture.tree), MLRT_OK);
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; ++i) {
        const float from[3] = {0.48f * distances[i], -0.8f * distances[i], 0.36f * distances[i]};
        for (int32_t method = MLRT_METHOD_PACKET2; method <= MLRT_METHOD_MULTILEVEL; ++method) {
            struct ray_list list = {0};
            add_far_rays(&list, &random, &scene, from, 0, 256);
            add_far_rays(&list, &random, &scene, from, 2, 256);
            mlrt_counters counters = {.struct_size = sizeof counters};
            const mlrt_rays rays = public_rays(&list);
            mlrt_trace_options options = {.struct_size = sizeof options, .method = method, .counters = &counters};
            struct reference_hit *hits = allocate_or_fail(list.count, sizeof *hits);
            struct reference_hit *wanted = allocate_or_fail(list.count, sizeof *wanted);
            memset(hits, 0, list.count * sizeof *hits);
            memset(wanted, 0, list.count * sizeof *wanted);
            const mlrt_hits results = public_hits(hits, 0), reference = public_hits(wanted, 0);
            assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &results), MLRT_OK);
            const uint64_t effort = counters.triangle_test_count + counters.judged_lane_count;
            if (effort > 128 * list.count) {
                fail_msg("distance %g, method %d: %.0f tests and close calls of a ray", (double)distances[i], method,
                         (double)effort / (double)list.count);
            }
            options.method = MLRT_METHOD_RAY;
            assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &reference), MLRT_OK);
            assert_memory_equal(hits, wanted, list.count * sizeof *hits);
            free(hits);
            free(wanted);
            free_rays(&list);
        }
    }
    mlrt_destroy_tree(fixture.tree);
    free_soup(&all);
    free_soup(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_give_up),
        cmocka_unit_test(test_scales),
        cmocka_unit_test(test_odd_triangles),
        cmocka_unit_test(odd_triangles_have_close_neighbours),
        cmocka_unit_test(distances_about_the_least_normal_float),
        cmocka_unit_test(given_distances_about_the_least_normal_float),
        cmocka_unit_test(origins_that_underflow_in_units),
        cmocka_unit_test(test_odd_triangles_stay_local),
        cmocka_unit_test(test_scales_have_one_tree),
        cmocka_unit_test(test_far_origins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
