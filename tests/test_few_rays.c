/* SPDX-License-Identifier: MIT */
/*
 * Where few rays of a tile meet something they go on one by one (trace_few_of_bundle): in meshes much finer than the
 * picture, which have exact ties, and whose answers must be those of rays that were alone from the start.
 */
#include <math.h>
#include <string.h>

#include "run/dispatch.h"
#include "support.h"

enum { WIDTH = 44, HEIGHT = 36, COUNT = WIDTH * HEIGHT };

/* A fine ball and a part of it once more, a fine floor, and something larger in front. */
static struct fixture make_fine_scene(uint64_t seed)
{
    struct random random = {seed};
    struct soup soup = {0};
    const float lo[3] = {-0.2f, -1.4f, -0.3f}, hi[3] = {0.3f, -1.2f, 0.1f};
    soup_add_icosphere(&soup, 5, 1);
    soup_add_icosphere(&soup, 4, 0.97f);
    if (seed % 2) soup_add_icosphere(&soup, 5, 1);
    if (seed % 3) soup_add_torus(&soup, 160, 50, 0.8f, 0.3f);
    if (seed % 4 > 1) soup_add_grid(&soup, 2, -0.75f, 60);
    if (seed % 5 > 2) soup_add_box(&soup, lo, hi);
    soup_add_random(&soup, &random, 300, 1.2f, 0.05f);
    return fixture_of_soup("fine meshes", seed, &soup);
}

struct answers {
    uint32_t triangle[COUNT];
    float t[COUNT];
    uint8_t occluded[COUNT];
};

/* Rays of one origin, of one direction, or to a light. */
enum kind { ORIGIN, DIRECTION, POINT_LIGHT, SUN, KIND_COUNT };

struct question {
    enum kind kind;
    int has_limits;
    float origins[COUNT][3]; /* or points */
    float directions[COUNT][3];
    float t_min[COUNT];
    float t_max[COUNT];
    uint32_t skip[COUNT][2];
    mlrt_light light;
};

static void ask(const mlrt_tree *tree, const struct question *question, mlrt_trace_options options,
                struct answers *answers)
{
    const mlrt_array occluded = {answers->occluded, 0, 0};
    memset(answers, 0x77, sizeof *answers);
    if (question->kind >= POINT_LIGHT) {
        const mlrt_points points = {.struct_size = sizeof points,
                                    .row_length = WIDTH,
                                    .count = COUNT,
                                    .positions = {question->origins, 0},
                                    .skip = {question->skip, 0}};
        assert_int_equal(mlrt_occluded_points(tree, &points, &question->light, &options, &occluded), MLRT_OK);
        return;
    }
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .row_length = WIDTH,
                      .count = COUNT,
                      .origins = {question->origins, 0},
                      .directions = {question->directions, 0},
                      .skip = {question->skip, 0}};
    if (question->has_limits) {
        rays.t_min.data = question->t_min;
        rays.t_max.data = question->t_max;
    }
    mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {answers->triangle, 0, 0}, .t = {answers->t, 0, 0}};
    assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
    options.query = MLRT_QUERY_ANY;
    hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = occluded};
    assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
}

static void draw_question(const struct fixture *fixture, struct random *random, enum kind kind,
                          struct question *question)
{
    static struct answers seen;
    float eye[3], target[3];
    draw_point(random, 0.1f, 1, eye);
    draw_point(random, -0.3f, 0.3f, target);
    const float away = draw_range(random, 2, 9) / hypotf(hypotf(eye[0], eye[1]), eye[2]);
    for (int k = 0; k < 3; k++) eye[k] *= draw_below(random, 2) ? away : -away;
    const mlrt_camera camera = look_at(eye, target, draw_range(random, 0.3f, 1.5f), WIDTH, HEIGHT);
    const float spread = draw_range(random, 0.5f, 3);
    question->kind = kind == DIRECTION ? DIRECTION : ORIGIN;
    question->has_limits = kind < POINT_LIGHT && draw_below(random, 3) == 0;
    for (size_t i = 0; i < COUNT; i++) {
        const float x = (float)(i % WIDTH) + 0.5f, y = (float)(i / WIDTH) + 0.5f;
        for (int k = 0; k < 3; k++) {
            const float d = camera.d00[k] + x * camera.dx[k] + y * camera.dy[k];
            question->origins[i][k] = kind == DIRECTION ? eye[k] + spread * d : eye[k];
            question->directions[i][k] = kind == DIRECTION ? target[k] - eye[k] : d;
        }
        question->t_min[i] = draw_range(random, -1, 1);
        question->t_max[i] = draw_below(random, 3) ? INFINITY : draw_range(random, 0.5f, 2) * away;
        question->skip[i][0] = draw_below(random, 9) ? 0 : MLRT_NONE;
        question->skip[i][1] = draw_below(random, 20000);
    }
    if (kind < POINT_LIGHT) return;
    /* Points on what is seen, or where nothing is, somewhere. */
    ask(fixture->tree, question, (mlrt_trace_options){.struct_size = sizeof(mlrt_trace_options)}, &seen);
    for (size_t i = 0; i < COUNT; i++) {
        const float t = seen.triangle[i] == MLRT_NONE ? draw_range(random, 0.5f, 2) : seen.t[i];
        for (int k = 0; k < 3; k++) question->origins[i][k] += t * question->directions[i][k];
        question->skip[i][1] = seen.triangle[i];
    }
    question->kind = kind;
    question->light = (mlrt_light){.struct_size = sizeof question->light,
                                   .kind = kind == SUN ? MLRT_LIGHT_DIRECTIONAL : MLRT_LIGHT_POINT};
    draw_point(random, -4, 4, question->light.position);
}

/* How many rays went alone, or parts of them. */
static uint64_t count_alone(const mlrt_tree *tree, const struct question *question)
{
    static struct answers answers;
    mlrt_counters counters = {.struct_size = sizeof counters};
    mlrt_trace_options options = {.struct_size = sizeof options, .counters = &counters};
    ask(tree, question, options, &answers);
    return counters.packet_count;
}

/* Method tile and method ray, with all instruction sets. */
static void compare_ways(const struct fixture *fixture, const struct question *question, uint64_t seed, int round)
{
    static struct answers expected, got;
    mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_RAY};
    ask(fixture->tree, question, options, &expected);
    options.method = MLRT_METHOD_TILE;
    for (options.isa = MLRT_ISA_SCALAR; options.isa <= MLRT_ISA_NEON; options.isa++) {
        if (!mlrt_select_kernels(&mlrt_structure_bvh, options.isa, MLRT_METHOD_TILE, 0)) continue;
        ask(fixture->tree, question, options, &got);
        for (size_t i = 0; i < COUNT; i++) {
            if (got.triangle[i] == expected.triangle[i] && memcmp(&got.t[i], &expected.t[i], 4) == 0 &&
                got.occluded[i] == expected.occluded[i]) {
                continue;
            }
            fail_msg("seed %u, round %d, isa %d, ray %u: triangle %u at %.9g, not %u at %.9g; any %d, not %d",
                     (unsigned)seed, round, (int)options.isa, (unsigned)i, got.triangle[i], (double)got.t[i],
                     expected.triangle[i], (double)expected.t[i], got.occluded[i], expected.occluded[i]);
        }
    }
}

static void same_as_alone(void **state)
{
    (void)state;
    static struct question question;
    enum { ROUNDS = SANITIZED ? 2 : 4 };
    uint64_t alone[KIND_COUNT] = {0};
    for (uint64_t seed = 0; seed < 3 + (SANITIZED ? 0 : 4); seed++) {
        struct random random = {4100 + seed};
        struct fixture fixture = make_fine_scene(seed);
        for (int round = 0; round < ROUNDS * KIND_COUNT; round++) {
            const enum kind kind = (enum kind)(round % KIND_COUNT);
            draw_question(&fixture, &random, kind, &question);
            compare_ways(&fixture, &question, seed, round);
            if (seed < 3) alone[kind] += count_alone(fixture.tree, &question);
        }
        free_fixture(&fixture);
    }
    for (int kind = 0; kind < KIND_COUNT; kind++) assert_true(4 * alone[kind] > 3 * ROUNDS * COUNT);
}

/* Needles: every packet passes hundreds of them, and few of its rays hit one. */
static struct fixture make_needles(uint64_t seed)
{
    struct random random = {seed};
    struct soup soup = {0};
    for (int i = 0; i < 5000; i++) {
        float a[3], b[3], c[3];
        draw_point(&random, -1, 1, a);
        draw_point(&random, -0.5f, 0.5f, b);
        for (int k = 0; k < 3; k++) {
            b[k] += a[k];
            c[k] = b[k] + draw_range(&random, -2e-3f, 2e-3f);
        }
        soup_add_triangle(&soup, a, b, c);
    }
    if (seed % 2) soup_add_icosphere(&soup, 3, 0.6f);
    return fixture_of_soup("needles", seed, &soup);
}

/* A packet that has been tested too often goes on lane by lane, wherever it is, with what it has hit so far. */
static void tedious_packets(void **state)
{
    (void)state;
    static struct question question;
    for (uint64_t seed = 0; seed < 2; seed++) {
        struct random random = {4400 + seed};
        struct fixture fixture = make_needles(seed);
        for (int round = (int)first_variant(); round < 3 * KIND_COUNT; round += (int)variant_step()) {
            draw_question(&fixture, &random, (enum kind)(round % KIND_COUNT), &question);
            compare_ways(&fixture, &question, seed, round);
        }
        free_fixture(&fixture);
    }
}

/* Cells of a camera have no rays until they are opened. */
static void pictures(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 1 + scaled(2); seed++) {
        struct random random = {4300 + seed};
        struct fixture fixture = make_fine_scene(seed);
        for (int i = 0; i < 6; i++) {
            float eye[3], target[3];
            draw_point(&random, 1, 2, eye);
            draw_point(&random, -0.3f, 0.3f, target);
            for (int k = 0; k < 3; k++) eye[k] *= draw_below(&random, 2) ? 2 : -2;
            const mlrt_camera camera = look_at(eye, target, draw_range(&random, 0.3f, 1.5f), WIDTH, HEIGHT);
            check_camera_quickly(&fixture, &camera);
        }
        free_fixture(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_as_alone),
        cmocka_unit_test(tedious_packets),
        cmocka_unit_test(pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
