/* SPDX-License-Identifier: MIT */
/*
 * Header and library of different versions: structs that are shorter than the library's, as of an older header, and
 * longer ones, as of a newer header, with zeros or with something in what the library does not know. And what can be
 * asked before anything else.
 */
#include <stdlib.h>
#include <string.h>

#include "base/structs.h"
#include "support.h"

/* A struct with room behind it, as a newer version would have. */
#define NEWER(type)                                                                                                    \
    struct {                                                                                                           \
        type own;                                                                                                      \
        uint32_t more[4];                                                                                              \
    }

static const float CORNERS[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};

static mlrt_mesh one_triangle(void)
{
    return (mlrt_mesh){.struct_size = sizeof(mlrt_mesh), .vertices = CORNERS, .vertex_count = 3, .triangle_count = 1};
}

static mlrt_tree *build_one(void)
{
    const mlrt_mesh mesh = one_triangle();
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    return tree;
}

/* ---- taking and giving ------------------------------------------------------------------------------------------- */

struct sample {
    uint32_t struct_size;
    uint32_t old;
    uint32_t added;
};

/* Options of the first version ended with the counters. */
#define FIRST_SIZE (offsetof(mlrt_trace_options, counters) + sizeof(mlrt_counters *))

static int32_t take(const void *given, mlrt_trace_options *own)
{
    return mlrt_take_struct(MLRT_STRUCT_TRACE_OPTIONS, "options", 0, given, own);
}

static void what_is_not_given_is_0(void **state)
{
    (void)state;
    mlrt_trace_options given, own;
    memset(&given, 0xFF, sizeof given);
    memset(&own, 0xFF, sizeof own);
    memset(&given, 0, FIRST_SIZE);
    given.struct_size = FIRST_SIZE;
    given.outputs = 5;
    assert_int_equal(take(&given, &own), MLRT_OK);
    assert_int_equal(own.struct_size, sizeof own);
    assert_int_equal(own.outputs, 5);
    assert_null(own.host);
    assert_null(own.lights);
    assert_int_equal(own.light_count, 0);
}

static void what_is_not_known_must_be_0(void **state)
{
    (void)state;
    NEWER(mlrt_trace_options) given;
    mlrt_trace_options own;
    memset(&given, 0, sizeof given);
    given.own.struct_size = sizeof given;
    given.own.outputs = 6;
    assert_int_equal(take(&given, &own), MLRT_OK);
    assert_int_equal(own.outputs, 6);
    assert_int_equal(own.struct_size, sizeof own);
    for (int i = 0; i < 4; i++) {
        given.more[i] = 1u << 31;
        assert_int_equal(take(&given, &own), MLRT_ERROR_STRUCT_SIZE);
        given.more[i] = 0;
    }
}

static void sizes_that_no_version_has(void **state)
{
    (void)state;
    static const uint32_t wrong[] = {0,
                                     1,
                                     4,
                                     FIRST_SIZE - 4,
                                     FIRST_SIZE - 1,
                                     FIRST_SIZE + 1,
                                     FIRST_SIZE + 2,
                                     sizeof(mlrt_trace_options) + 260,
                                     0xFFFFFFFFu};
    uint32_t given[256] = {0};
    mlrt_trace_options own;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        given[0] = wrong[i];
        assert_int_equal(take(given, &own), MLRT_ERROR_STRUCT_SIZE);
        assert_int_equal(mlrt_check_result_size(MLRT_STRUCT_TRACE_OPTIONS, "options", given), MLRT_ERROR_STRUCT_SIZE);
    }
    given[0] = sizeof(mlrt_trace_options) + 256;
    assert_int_equal(take(given, &own), MLRT_OK);
}

static void results_are_as_long_as_the_callers_struct(void **state)
{
    (void)state;
    const struct sample own = {sizeof own, 5, 6};
    uint32_t given[5] = {8, 1, 2, 3, 4};
    mlrt_give_struct(&own, sizeof own, given);
    assert_int_equal(given[0], 8);
    assert_int_equal(given[1], 5);
    assert_int_equal(given[2], 2);
    given[0] = 16;
    mlrt_give_struct(&own, sizeof own, given);
    assert_int_equal(given[2], 6);
    assert_int_equal(given[3], 0);
    assert_int_equal(given[4], 4);
}

/* ---- the interface ----------------------------------------------------------------------------------------------- */

/* As the header of version 0.1 has them: without what was added since. */
static void older_structs(void **state)
{
    (void)state;
    const mlrt_mesh mesh = one_triangle();
    const float origin[3] = {0.25f, 0.25f, 0}, direction[3] = {0, 0, 1};
    float t = 0;
    mlrt_trace_options trace = {.host = (const mlrt_host *)(uintptr_t)16};
    mlrt_rays rays = {.count = 1, .origins = {origin, 0}, .directions = {direction, 0}};
    mlrt_hits hits = {.struct_size = sizeof hits, .t = {&t, 0, 0}};
    mlrt_tree *tree;
    trace.struct_size = offsetof(mlrt_trace_options, host);
    rays.struct_size = offsetof(mlrt_rays, mask);
    rays.mask = (mlrt_const_array){origin, 3};
    rays.rays_per_origin = 7;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    assert_int_equal(mlrt_trace_packet(tree, &rays, &trace, &hits), MLRT_OK);
    assert_true(t == 5);
    mlrt_destroy_tree(tree);
}

static void newer_structs(void **state)
{
    (void)state;
    const float origin[3] = {0.25f, 0.25f, 0}, direction[3] = {0, 0, 1};
    NEWER(mlrt_mesh) meshes[2] = {{one_triangle(), {0}}, {one_triangle(), {0}}};
    NEWER(mlrt_ray) ray = {.own = {.struct_size = sizeof ray}};
    NEWER(mlrt_hit) hit = {.own = {.struct_size = sizeof hit}, .more = {1, 2, 3, 4}};
    NEWER(mlrt_tree_info) info = {.own = {.struct_size = sizeof info}, .more = {1, 2, 3, 4}};
    NEWER(mlrt_counters) counters = {.own = {.struct_size = sizeof counters}, .more = {1, 2, 3, 4}};
    const mlrt_trace_options options = {.struct_size = sizeof options, .counters = &counters.own};
    mlrt_tree *tree;
    memcpy(ray.own.origin, origin, sizeof origin);
    memcpy(ray.own.direction, direction, sizeof direction);
    for (int i = 0; i < 2; i++) meshes[i].own.struct_size = sizeof meshes[i];
    assert_int_equal(mlrt_build_tree(&meshes[0].own, 2, NULL, &tree), MLRT_OK);
    assert_int_equal(mlrt_trace_ray(tree, &ray.own, &options, &hit.own), MLRT_OK);
    assert_true(hit.own.t == 5);
    assert_int_equal(hit.own.struct_size, sizeof hit);
    assert_int_equal(mlrt_get_tree_info(tree, &info.own), MLRT_OK);
    assert_int_equal(info.own.triangle_count, 2);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(hit.more[i], 0);
        assert_int_equal(info.more[i], 0);
        assert_int_equal(counters.more[i], i + 1); /* these are added to */
    }
    assert_int_equal(counters.own.ray_count, 1);
    ray.more[3] = 1;
    assert_int_equal(mlrt_trace_ray(tree, &ray.own, NULL, &hit.own), MLRT_ERROR_STRUCT_SIZE);
    mlrt_destroy_tree(tree);
    meshes[1].more[0] = 1;
    assert_int_equal(mlrt_build_tree(&meshes[0].own, 2, NULL, &tree), MLRT_ERROR_STRUCT_SIZE);
    meshes[1].more[0] = 0;
    meshes[1].own.struct_size = sizeof(mlrt_mesh);
    assert_int_equal(mlrt_build_tree(&meshes[0].own, 2, NULL, &tree), MLRT_ERROR_STRUCT_SIZE);
}

/* What options had before there were lights: what lies behind is somebody else's. */
static void options_from_before_there_were_lights(void **state)
{
    (void)state;
    mlrt_tree *tree = build_one();
    const mlrt_camera camera = {
        .struct_size = sizeof camera, .width = 2, .height = 2, .d00 = {0, 0, 1}, .dx = {0.05f}, .dy = {0, 0.05f, 0}};
    mlrt_trace_options options = {
        .struct_size = offsetof(mlrt_trace_options, lights), .light_count = 77, .reserved = 78};
    options.lights = (const mlrt_light *)(uintptr_t)16;
    float t[4] = {0};
    uint8_t occluded[4];
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
    assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
    assert_true(t[3] == 5);
    frame.occluded.data = occluded;
    assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

/* Lights of a newer version, with room behind each. */
static void newer_lights(void **state)
{
    (void)state;
    mlrt_tree *tree = build_one();
    const mlrt_camera camera = {
        .struct_size = sizeof camera, .width = 2, .height = 2, .d00 = {0, 0, 1}, .dx = {0.05f}, .dy = {0, 0.05f, 0}};
    NEWER(mlrt_light) lights[3];
    for (int i = 0; i < 3; i++) {
        memset(&lights[i], 0, sizeof lights[i]);
        lights[i].own = (mlrt_light){.struct_size = sizeof lights[i], .position = {0, 0, i == 1 ? 9.0f : 1.0f}};
    }
    const mlrt_trace_options options = {.struct_size = sizeof options, .lights = &lights[0].own, .light_count = 3};
    uint8_t occluded[4];
    const mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {occluded, 0, 0}};
    assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
    for (int i = 0; i < 4; i++) assert_int_equal(occluded[i], 2);
    lights[2].more[3] = 1;
    assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_ERROR_STRUCT_SIZE);
    mlrt_destroy_tree(tree);
}

static void shadow_rays_of_newer_structs(void **state)
{
    (void)state;
    mlrt_tree *tree = build_one();
    NEWER(mlrt_ray)
    ray = {.own = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}}};
    NEWER(mlrt_hit) hit = {.own = {.struct_size = sizeof hit}};
    NEWER(mlrt_light) light = {.own = {.struct_size = sizeof light, .position = {1, 2, 3}}};
    NEWER(mlrt_ray) shadow = {.own = {.struct_size = sizeof shadow}, .more = {1, 2, 3, 4}};
    int32_t faces;
    assert_int_equal(mlrt_shadow_ray(tree, &ray.own, &hit.own, &light.own, &shadow.own, &faces), MLRT_OK);
    assert_int_equal(faces, 1);
    assert_int_equal(shadow.own.struct_size, sizeof shadow);
    assert_true(shadow.own.t_max == 1);
    for (int i = 0; i < 4; i++) assert_int_equal(shadow.more[i], 0);
    hit.more[0] = 1;
    assert_int_equal(mlrt_shadow_ray(tree, &ray.own, &hit.own, &light.own, &shadow.own, &faces),
                     MLRT_ERROR_STRUCT_SIZE);
    mlrt_destroy_tree(tree);
}

/* With MLRT_QUERY_ANY only `occluded` is written, whatever the length. */
static void fields_that_the_query_does_not_write_stay(void **state)
{
    (void)state;
    mlrt_tree *tree = build_one();
    const mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    const mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY};
    mlrt_hit hit = {.struct_size = sizeof hit, .t = 77, .mesh = 78};
    assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_OK);
    assert_true(hit.t == 77 && hit.mesh == 78);
    assert_int_equal(hit.occluded, 1);
    mlrt_destroy_tree(tree);
}

/* ---- before anything else ---------------------------------------------------------------------------------------- */

static void sizes_of_structs(void **state)
{
    (void)state;
    uint32_t sizes[MLRT_STRUCT_COUNT + 2];
    memset(sizes, 0xA5, sizeof sizes);
    mlrt_struct_sizes(sizes, MLRT_STRUCT_COUNT + 1);
    for (int i = 0; i < MLRT_STRUCT_COUNT; i++) assert_true(sizes[i] >= 12 && sizes[i] <= 300);
    assert_int_equal(sizes[MLRT_STRUCT_MESH], sizeof(mlrt_mesh));
    assert_int_equal(sizes[MLRT_STRUCT_TRACE_OPTIONS], sizeof(mlrt_trace_options));
    assert_int_equal(sizes[MLRT_STRUCT_POINTS], sizeof(mlrt_points));
    assert_int_equal(sizes[MLRT_STRUCT_COUNT], 0);
    assert_int_equal(sizes[MLRT_STRUCT_COUNT + 1], 0xA5A5A5A5u);
    sizes[1] = 0;
    mlrt_struct_sizes(sizes, 1);
    assert_int_equal(sizes[0], sizeof(mlrt_host));
    assert_int_equal(sizes[1], 0);
    mlrt_struct_sizes(NULL, 0);
}

static void capabilities_are_what_can_be_asked_for(void **state)
{
    (void)state;
    mlrt_tree *tree = build_one();
    const uint64_t capabilities = mlrt_capabilities();
    const mlrt_ray ray = {.struct_size = sizeof ray, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    for (int32_t isa = MLRT_ISA_SSE; isa <= MLRT_ISA_NEON; isa++) {
        const mlrt_trace_options options = {.struct_size = sizeof options, .isa = isa};
        static const uint64_t bits[] = {MLRT_CAN_SSE, MLRT_CAN_AVX2, MLRT_CAN_AVX512, MLRT_CAN_NEON};
        const int32_t expected = capabilities & bits[isa - MLRT_ISA_SSE] ? MLRT_OK : MLRT_ERROR_UNSUPPORTED;
        assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), expected);
    }
    mlrt_destroy_tree(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_not_given_is_0),
        cmocka_unit_test(what_is_not_known_must_be_0),
        cmocka_unit_test(sizes_that_no_version_has),
        cmocka_unit_test(results_are_as_long_as_the_callers_struct),
        cmocka_unit_test(older_structs),
        cmocka_unit_test(newer_structs),
        cmocka_unit_test(options_from_before_there_were_lights),
        cmocka_unit_test(newer_lights),
        cmocka_unit_test(shadow_rays_of_newer_structs),
        cmocka_unit_test(fields_that_the_query_does_not_write_stay),
        cmocka_unit_test(sizes_of_structs),
        cmocka_unit_test(capabilities_are_what_can_be_asked_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
