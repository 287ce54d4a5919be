/* SPDX-License-Identifier: MIT */
/*
 * mlrt_trace_packet with few rays, which need no job: the answers are those of one call with all rays by method ray, for
 * hostile rays and limits, any strides, and results that lie on the rays. And exception flags of calls of one ray.
 */
#include <fenv.h>
#include <math.h>
#include <string.h>

#include "hard_scenes.h"
#include "hostile_rays.h"
#include "support.h"

enum { COUNT = 600, MOST = 6 };

struct record {
    float origin[3];
    float t_min;
    float direction[3];
    float t_max;
};

struct answers {
    struct reference_hit hits[COUNT];
    uint8_t occluded[COUNT];
};

static float draw_limit(struct random *random, float usual)
{
    const float limits[] = {0, -0.0f, -1, NAN, 1e-40f, INFINITY, 1e30f, -INFINITY};
    const uint32_t i = draw_below(random, 4 * sizeof limits / sizeof limits[0]);
    return i < sizeof limits / sizeof limits[0] ? limits[i] : usual;
}

static void make_records(struct random *random, const struct fixture *fixture, struct record *records)
{
    struct ray_list list = {0};
    while (list.count < COUNT) add_hostile_rays(&list, random, fixture, draw_hostile_kind(random), 20);
    for (size_t i = 0; i < COUNT; i++) {
        const struct reference_ray *ray = &list.rays[draw_below(random, (uint32_t)list.count)];
        memcpy(records[i].origin, ray->origin, sizeof ray->origin);
        memcpy(records[i].direction, ray->direction, sizeof ray->direction);
        records[i].t_min = draw_limit(random, ray->t_min);
        records[i].t_max = draw_limit(random, ray->t_max);
    }
    free_rays(&list);
}

static mlrt_rays rays_of(const struct record *records, size_t count, int has_t_min, int has_t_max)
{
    return (mlrt_rays){.struct_size = sizeof(mlrt_rays),
                       .count = count,
                       .origins = {records->origin, sizeof *records},
                       .directions = {records->direction, sizeof *records},
                       .t_min = {has_t_min ? &records->t_min : NULL, sizeof *records},
                       .t_max = {has_t_max ? &records->t_max : NULL, sizeof *records}};
}

static void trace(const struct fixture *fixture, const mlrt_rays *rays, const mlrt_trace_options *options,
                  struct reference_hit *found, uint8_t *occluded)
{
    mlrt_hits hits = {.struct_size = sizeof hits};
    if (options->query == MLRT_QUERY_ANY)
        hits.occluded.data = occluded;
    else
        hits = public_hits(found, 0);
    assert_int_equal(mlrt_trace_packet(fixture->tree, rays, options, &hits), MLRT_OK);
}

/* Calls of 1 to MOST rays, one after the other. */
static void trace_in_pieces(struct random *random, const struct fixture *fixture, const struct record *records,
                            int has_t_min, int has_t_max, const mlrt_trace_options *options, struct answers *answers)
{
    for (size_t i = 0, count; i < COUNT; i += count) {
        count = 1 + draw_below(random, MOST);
        if (count > COUNT - i) count = COUNT - i;
        const mlrt_rays rays = rays_of(records + i, count, has_t_min, has_t_max);
        trace(fixture, &rays, options, answers->hits + i, answers->occluded + i);
    }
}

static void check_scene(const struct fixture *fixture, struct random *random)
{
    static struct answers expected, got;
    struct record records[COUNT];
    make_records(random, fixture, records);
    for (int variant = 0; variant < 8; variant++) {
        const int has_t_min = variant & 1, has_t_max = variant & 2;
        mlrt_trace_options options = {.struct_size = sizeof options,
                                      .query = variant & 4 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST,
                                      .method = MLRT_METHOD_RAY};
        const mlrt_rays all = rays_of(records, COUNT, has_t_min, has_t_max);
        memset(&expected, 0, sizeof expected);
        memset(&got, 0, sizeof got);
        trace(fixture, &all, &options, expected.hits, expected.occluded);
        options.method = MLRT_METHOD_DEFAULT;
        trace_in_pieces(random, fixture, records, has_t_min, has_t_max, &options, &got);
        for (size_t i = 0; i < COUNT; i++) {
            if (!memcmp(&expected.hits[i], &got.hits[i], sizeof got.hits[i]) && expected.occluded[i] == got.occluded[i])
                continue;
            print_error("%s, seed %llu, variant %d: ray %zu differs\n", fixture->name,
                        (unsigned long long)fixture->seed, variant, i);
            fail();
        }
    }
}

static void same_as_in_one_call(void **state)
{
    (void)state;
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct random random = {7700 + i};
        struct fixture fixture = make_hard_scene(i);
        check_scene(&fixture, &random);
        free_fixture(&fixture);
    }
}

/* t of ray i goes to a number of ray i + 1: all rays are read before a result is written. */
static void results_on_the_rays(void **state)
{
    (void)state;
    const float wall[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    for (size_t count = 1; count <= MOST; count++) {
        for (int word = 0; word < 8; word++) {
            struct record records[MOST + 1];
            for (size_t i = 0; i <= MOST; i++) {
                records[i] = (struct record){{0, 0, (float)i}, 0, {0, 0, 1}, 100};
            }
            const mlrt_rays rays = rays_of(records, count, 1, 1);
            const mlrt_hits hits = {.struct_size = sizeof hits,
                                    .t = {(char *)&records[1] + 4 * word, sizeof *records, 0}};
            assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_OK);
            for (size_t i = 0; i < count; i++) {
                float t;
                memcpy(&t, (const char *)&records[i + 1] + 4 * word, sizeof t);
                assert_float_equal(t, 5 > (float)i ? 5 - (float)i : INFINITY, 0);
            }
        }
    }
    mlrt_destroy_tree(tree);
}

/* A byte array, with a stride, for any hit; bytes between its elements stay. */
static void bytes_between_results_stay(void **state)
{
    (void)state;
    const float wall[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    const mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    for (size_t count = 1; count <= MOST; count++) {
        struct record records[MOST];
        uint8_t bytes[3 * MOST];
        memset(bytes, 7, sizeof bytes);
        for (size_t i = 0; i < MOST; i++) records[i] = (struct record){{0, 0, 0}, 0, {0, 0, i % 2 ? 1.0f : -1.0f}, 100};
        const mlrt_rays rays = rays_of(records, count, 1, 1);
        const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {bytes, 3, 0}};
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        for (size_t i = 0; i < sizeof bytes; i++) {
            assert_int_equal(bytes[i], i % 3 == 0 && i / 3 < count ? (i / 3) % 2 : 7);
        }
    }
    mlrt_destroy_tree(tree);
}

/* A triangle without area, so small or large that boxes have another unit, leaves a tree without nodes. */
static void trees_without_nodes(void **state)
{
    (void)state;
    for (int exponent = -60; exponent <= 60; exponent += 60) {
        const float x = ldexpf(1, exponent);
        const float line[9] = {x, x, x, 2 * x, x, x, 3 * x, x, x};
        const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = line, .vertex_count = 3, .triangle_count = 1};
        const mlrt_ray ray = {.struct_size = sizeof ray, .origin = {2 * x, x, 0}, .direction = {0, 0, 1}};
        mlrt_hit hit = {.struct_size = sizeof hit};
        float t = 0;
        const mlrt_rays rays = {
            .struct_size = sizeof rays, .count = 1, .origins = {ray.origin, 0}, .directions = {ray.direction, 0}};
        const mlrt_hits hits = {.struct_size = sizeof hits, .t = {&t, 0, 0}};
        mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
        assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_OK);
        assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_OK);
        assert_int_equal(hit.triangle, MLRT_NONE);
        assert_true(isinf(t));
        mlrt_destroy_tree(tree);
    }
}

/* Mistakes are found however few the rays are. */
static void mistakes_are_errors(void **state)
{
    (void)state;
    const float wall[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    struct record records[1] = {{{0, 0, 0}, 0, {0, 0, 1}, 100}};
    float t[2];
    uint8_t occluded[1];
    for (int mistake = 0; mistake < 10; mistake++) {
        mlrt_rays rays = rays_of(records, 1, 1, 1);
        mlrt_hits hits = {.struct_size = sizeof hits, .t = {t, 0, 0}};
        mlrt_trace_options options = {.struct_size = sizeof options};
        if (mistake == 1) rays.origins.stride = 13;
        if (mistake == 2) rays.directions.stride = 14;
        if (mistake == 3) rays.directions.data = NULL;
        if (mistake == 4) rays.reserved = 1;
        if (mistake == 5) hits.occluded.data = occluded;
        if (mistake == 6) hits.t.stride = 2;
        if (mistake == 7) hits.t.data = (unsigned char *)t + 1;
        if (mistake == 8) options.query = 2;
        if (mistake == 9) options.query = MLRT_QUERY_ANY;
        const int32_t status = mlrt_trace_packet(tree, &rays, &options, &hits);
        if (status != (mistake ? MLRT_ERROR_ARGUMENT : MLRT_OK))
            fail_msg("mistake %d: status %d", mistake, (int)status);
    }
    mlrt_destroy_tree(tree);
}

/*
 * Calls leave the caller's exception flags as they were: none, or inexact alone, where a ray that misses the scene does
 * not look at them again.
 */
static void exception_flags_stay(void **state)
{
    (void)state;
    static struct record records[COUNT];
    int wrong = 0;
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct random random = {9900 + i};
        struct fixture fixture = make_hard_scene(i);
        make_records(&random, &fixture, records);
        for (size_t j = 0; j < COUNT; j++) {
            const int flags = j % 2 ? FE_INEXACT : 0;
            mlrt_ray ray = {.struct_size = sizeof ray, .t_min = records[j].t_min, .t_max = records[j].t_max};
            mlrt_hit hit = {.struct_size = sizeof hit};
            memcpy(ray.origin, records[j].origin, sizeof ray.origin);
            memcpy(ray.direction, records[j].direction, sizeof ray.direction);
            volatile float third = 1;
            feclearexcept(FE_ALL_EXCEPT);
            if (flags) third /= 3; /* feraiseexcept may raise the flag of another unit */
            mlrt_trace_ray(fixture.tree, &ray, NULL, &hit);
            const int found = fetestexcept(FE_ALL_EXCEPT);
            if (found == flags) continue;
            print_error("%s: ray %zu, flags %#x in place of %#x, o = (%a, %a, %a), d = (%a, %a, %a), t in (%a, %a]\n",
                        fixture.name, j, (unsigned)found, (unsigned)flags, (double)ray.origin[0], (double)ray.origin[1],
                        (double)ray.origin[2], (double)ray.direction[0], (double)ray.direction[1],
                        (double)ray.direction[2], (double)ray.t_min, (double)ray.t_max);
            wrong++;
        }
        free_fixture(&fixture);
    }
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_as_in_one_call),        cmocka_unit_test(results_on_the_rays),
        cmocka_unit_test(bytes_between_results_stay), cmocka_unit_test(trees_without_nodes),
        cmocka_unit_test(mistakes_are_errors),        cmocka_unit_test(exception_flags_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
