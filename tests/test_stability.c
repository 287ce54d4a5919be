/* SPDX-License-Identifier: MIT */
/*
 * Wrong decisions of every way of tracing: 0. Hard scenes times hostile rays against the reference, and the closed
 * sphere that no ray may leave. As one of the tests it runs on few rays; on a large scale:
 *
 *     test_stability --list                             the scenes and rays, and the hard cases they cover
 *     test_stability --scenes [PRODUCT] [--seconds N] [--only NAME]
 *                                                       every scene with PRODUCT / triangles rays, 1e9 if not given
 *                                                       (PRODUCT / 500 in scenes of fewer than 500 triangles), but
 *                                                       for no more than N seconds of processor time
 *     test_stability --worlds COUNT [FIRST]             so many worlds (worlds.h) from the number FIRST on
 *     test_stability --sphere                           all rays of the sphere
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bundle_rays.h"
#include "hard_scenes.h"
#include "hostile_rays.h"
#include "support.h"
#include "tally.h"
#include "worlds.h"

/* ---- hard scenes ------------------------------------------------------------------------------------------------- */

#define CASE_COUNT 46

/* Marks the numbers in a text like "1 19 45". */
static void mark_cases(const char *text, int marked[CASE_COUNT + 1])
{
    for (char *end; *text; text = end) {
        long number = strtol(text, &end, 10);
        assert_true(end != text && number >= 1 && number <= CASE_COUNT);
        marked[number] = 1;
    }
}

static void every_case_has_a_scene_or_a_ray(void **state)
{
    (void)state;
    int marked[CASE_COUNT + 1] = {0};
    for (size_t i = 0; i < hard_scene_count(); i++) mark_cases(hard_scene_at(i)->cases, marked);
    for (size_t i = 0; i < hostile_kind_count(); i++) mark_cases(hostile_kind_at(i)->cases, marked);
    for (int i = 1; i <= CASE_COUNT; i++) {
        if (!marked[i]) fail_msg("hard case %d: no scene and no kind of ray", i);
    }
}

static void every_hard_scene(void **state)
{
    (void)state;
    for (size_t i = first_variant(); i < hard_scene_count(); i += variant_step()) {
        struct fixture fixture = make_hard_scene(i);
        struct tally tally = {0};
        tally_hostile(&tally, &fixture, scaled(120), INFINITY);
        free_fixture(&fixture);
        if (tally.difference_count)
            fail_msg("%s: %llu differences", hard_scene_at(i)->name, (unsigned long long)tally.difference_count);
    }
}

static void list_scenes(void)
{
    printf("%-34s %9s  %s\n", "scene", "triangles", "hard cases");
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct fixture fixture = make_hard_scene(i);
        printf("%-34s %9zu  %s\n", fixture.name, reference_triangle_count(fixture.reference), hard_scene_at(i)->cases);
        free_fixture(&fixture);
    }
    printf("\n%-44s  %s\n", "rays, in every scene", "hard cases");
    for (size_t i = 0; i < hostile_kind_count(); i++)
        printf("%-44s  %s\n", hostile_kind_at(i)->name, hostile_kind_at(i)->cases);
}

static void print_row(const char *name, size_t triangle_count, const struct tally *tally, double product)
{
    printf("%-34s %9zu %11llu %9.2e %12llu %11llu %9.1f %9.1f\n", name, triangle_count,
           (unsigned long long)tally->ray_count, product, (unsigned long long)tally->answer_count,
           (unsigned long long)tally->difference_count, tally->reference_seconds, tally->library_seconds);
    fflush(stdout);
}

static void add_tally(struct tally *sum, const struct tally *tally)
{
    sum->ray_count += tally->ray_count;
    sum->answer_count += tally->answer_count;
    sum->difference_count += tally->difference_count;
    sum->reference_seconds += tally->reference_seconds;
    sum->library_seconds += tally->library_seconds;
}

static int run_scenes(double product, double seconds, const char *only)
{
    struct tally sum = {0};
    double product_sum = 0;
    printf("%zu ways of tracing\n%-34s %9s %11s %9s %12s %11s %9s %9s\n", tally_way_count(), "scene", "triangles",
           "rays", "product", "answers", "differences", "reference", "library");
    for (size_t i = 0; i < hard_scene_count(); i++) {
        if (only && strcmp(only, hard_scene_at(i)->name) != 0) continue;
        struct fixture fixture = make_hard_scene(i);
        struct tally tally = {0};
        size_t count = reference_triangle_count(fixture.reference);
        tally_hostile(&tally, &fixture, (uint64_t)(product / (double)(count < 500 ? 500 : count)), seconds);
        double done = (double)tally.ray_count * (double)count;
        print_row(fixture.name, count, &tally, done);
        add_tally(&sum, &tally);
        product_sum += done;
        free_fixture(&fixture);
    }
    print_row("total", 0, &sum, product_sum);
    return sum.difference_count != 0;
}

/* ---- worlds ------------------------------------------------------------------------------------------------------ */

/* Hostile rays, and two bundles: all ways of tracing but those that masks and strides take, which test_bundles draws. */
static void tally_world(struct tally *tally, uint64_t number)
{
    struct world world = {.mesh_count = 0};
    struct random random = {number};
    make_world(number, 1, &world);
    tally_hostile(tally, &world.fixture, 300, INFINITY);
    for (int i = 0; i < 2; i++) {
        const struct bundle_shape shape = {1 + draw_below(&random, 100), 1 + draw_below(&random, 32)};
        struct ray_list list = {0};
        add_bundle_rays(&list, &random, &world.fixture, draw_below(&random, (uint32_t)bundle_kind_count()), shape);
        spoil_bundle(&list, &random, &world.fixture);
        list.row_length = shape.width;
        tally_rays(tally, &world.fixture, &list, 1);
        if (i == 0) tally_lists(tally, &world.fixture, &list);
        free_rays(&list);
    }
    free_world(&world);
}

static void worlds_of_every_scene(void **state)
{
    (void)state;
    const uint64_t count = world_scene_count();
    for (uint64_t i = count; i < count + scaled(2 * count); i++) { // a half of them twisted
        struct tally tally = {0};
        tally_world(&tally, i);
        if (tally.difference_count)
            fail_msg("%llu differences: test_stability --worlds 1 %llu", (unsigned long long)tally.difference_count,
                     (unsigned long long)i);
    }
}

static int run_worlds(uint64_t count, uint64_t first)
{
    struct tally sum = {0};
    for (uint64_t i = 0; i < count; i++) {
        const uint64_t before = sum.difference_count;
        tally_world(&sum, first + i);
        if (sum.difference_count != before)
            printf("differences in world %llu: test_stability --worlds 1 %llu\n", (unsigned long long)(first + i),
                   (unsigned long long)(first + i));
        if (i + 1 == count || (i + 1) % 1000 == 0) {
            printf("%llu worlds, %llu rays, %llu answers, %llu differences\n", (unsigned long long)i + 1,
                   (unsigned long long)sum.ray_count, (unsigned long long)sum.answer_count,
                   (unsigned long long)sum.difference_count);
            fflush(stdout);
        }
    }
    return sum.difference_count != 0;
}

/* ---- the sphere -------------------------------------------------------------------------------------------------- */

#define SUBDIVISIONS    5
#define VERTEX_COUNT    10242
#define TRIANGLE_COUNT  20480
#define POINTS_PER_EDGE 4
#define RANDOM_COUNT    200000
#define FACE_SIDE       128

/* A closed mesh whose triangles share their vertices, and a point in it. */
struct sphere {
    float vertices[VERTEX_COUNT][3];
    uint32_t indices[TRIANGLE_COUNT][3];
    float inside[3];
};

struct column {
    const char *name;
    float scale;
    float shift;
    int any_length; /* 1 = directions of lengths 1e-30 to 1e30, else as they come */
};

static const struct column columns[] = {
    {"as is", 1, 0, 0},
    {"shift 1e3", 1, 1e3f, 0},
    {"shift 1e5", 1, 1e5f, 0},
    {"scale 1e-6", 1e-6f, 0, 0},
    {"scale 1e6", 1e6f, 0, 0},
    {"any length", 1, 0, 1},
    {"shift 1e5, any length", 1, 1e5f, 1},
    {"scale 1e-6, any length", 1e-6f, 0, 1},
    {"scale 1e6, any length", 1e6f, 0, 1},
};

static int compare_vertices(const void *a, const void *b)
{
    return memcmp(a, b, 3 * sizeof(float));
}

static struct sphere *make_sphere(const struct column *column)
{
    struct sphere *sphere = allocate_or_fail(1, sizeof *sphere);
    struct soup soup = {0};
    soup_add_icosphere(&soup, SUBDIVISIONS, 1);
    assert_int_equal(soup.count, TRIANGLE_COUNT);
    float *sorted = allocate_or_fail(9 * soup.count, sizeof *sorted);
    memcpy(sorted, soup.corners, 9 * soup.count * sizeof *sorted);
    qsort(sorted, 3 * soup.count, 3 * sizeof *sorted, compare_vertices);
    size_t used = 0;
    for (size_t i = 0; i < 3 * soup.count; i++) {
        if (i > 0 && compare_vertices(sorted + 3 * i, sorted + 3 * (i - 1)) == 0) continue;
        assert_true(used < VERTEX_COUNT);
        memcpy(sphere->vertices[used++], sorted + 3 * i, 3 * sizeof *sorted);
    }
    assert_int_equal(used, VERTEX_COUNT);
    for (size_t i = 0; i < 3 * soup.count; i++) {
        const float(*found)[3] =
            bsearch(soup.corners + 3 * i, sphere->vertices, VERTEX_COUNT, 3 * sizeof(float), compare_vertices);
        sphere->indices[i / 3][i % 3] = (uint32_t)(found - (const float(*)[3])sphere->vertices);
    }
    free(sorted);
    free_soup(&soup);
    static const float inside[3] = {0.1f, -0.2f, 0.3f};
    for (int k = 0; k < 3; k++) {
        double offset = k == 2 ? -(double)column->shift : (double)column->shift;
        for (size_t i = 0; i < VERTEX_COUNT; i++)
            sphere->vertices[i][k] = (float)((double)sphere->vertices[i][k] * (double)column->scale + offset);
        sphere->inside[k] = (float)((double)inside[k] * (double)column->scale + offset);
    }
    return sphere;
}

static void stretch(struct reference_ray *ray, struct random *random)
{
    double length = 0, wanted = pow(10, (double)draw_range(random, -30, 30));
    for (int k = 0; k < 3; k++) length = fmax(length, fabs((double)ray->direction[k]));
    for (int k = 0; k < 3; k++) ray->direction[k] = (float)((double)ray->direction[k] * wanted / length);
}

/* Rays at every vertex, at points of every edge, and random ones; of each kind only every `step`th. */
static void list_rays(const struct sphere *sphere, const struct column *column, uint32_t step, struct ray_list kinds[3])
{
    struct random random = {77};
    for (uint32_t i = 0; i < VERTEX_COUNT; i += step) add_ray_towards(&kinds[0], sphere->inside, sphere->vertices[i]);
    for (uint32_t i = 0; i < TRIANGLE_COUNT * 3; i++) {
        uint32_t from = sphere->indices[i / 3][i % 3], to = sphere->indices[i / 3][(i + 1) % 3];
        if (from > to || i % step) continue; // each edge from one side
        for (int n = 1; n <= POINTS_PER_EDGE; n++) {
            float target[3];
            double part = (double)n / (POINTS_PER_EDGE + 1);
            for (int k = 0; k < 3; k++)
                target[k] =
                    (float)((double)sphere->vertices[from][k] * (1 - part) + (double)sphere->vertices[to][k] * part);
            add_ray_towards(&kinds[1], sphere->inside, target);
        }
    }
    for (uint32_t i = 0; i < RANDOM_COUNT; i += step) {
        float direction[3];
        draw_point(&random, -1, 1, direction);
        add_ray(&kinds[2], sphere->inside, direction);
    }
    for (int kind = 0; kind < 3; kind++) {
        for (size_t i = 0; column->any_length && i < kinds[kind].count; i++) stretch(&kinds[kind].rays[i], &random);
    }
}

/* Closest hit as a list and as rows of a picture, and any hit. */
static size_t count_misses(const mlrt_tree *tree, const struct ray_list *list, const struct variant *variant)
{
    size_t misses = 0;
    uint32_t *triangles = allocate_or_fail(list->count, sizeof *triangles);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    for (int way = 0; way < 3; way++) {
        mlrt_rays rays = public_rays(list);
        mlrt_trace_options options = variant->options;
        mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {triangles, 0, 0}};
        if (way == 1) rays.row_length = 100;
        if (way == 2) {
            hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
            options.query = MLRT_QUERY_ANY;
        }
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        for (size_t i = 0; i < list->count; i++) misses += way == 2 ? !occluded[i] : triangles[i] == MLRT_NONE;
    }
    free(triangles);
    free(occluded);
    return misses;
}

/* The pixels of six pictures, one for each face of a cube around the point. */
static size_t count_missed_pixels(const mlrt_tree *tree, const float inside[3], const struct variant *variant,
                                  uint32_t side)
{
    size_t misses = 0;
    uint32_t *triangles = allocate_or_fail((size_t)side * side, sizeof *triangles);
    for (int face = 0; face < 6; face++) {
        mlrt_camera camera = {.struct_size = sizeof camera, .width = side, .height = side};
        int axis = face / 2;
        memcpy(camera.eye, inside, sizeof camera.eye);
        camera.d00[axis] = face % 2 ? -1.0f : 1.0f;
        camera.d00[(axis + 1) % 3] = camera.d00[(axis + 2) % 3] = -1;
        camera.dx[(axis + 1) % 3] = camera.dy[(axis + 2) % 3] = 2.0f / (float)side;
        mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {triangles, 0, 0}};
        assert_int_equal(mlrt_render_tiles(tree, &camera, &variant->options, &frame, NULL, NULL), MLRT_OK);
        for (size_t i = 0; i < (size_t)side * side; i++) misses += triangles[i] == MLRT_NONE;
    }
    free(triangles);
    return misses;
}

/* Misses of all fast ways, of one ray at a time, and of one column. */
static size_t run_column(const struct column *column, uint32_t step, int verbose)
{
    struct sphere *sphere = make_sphere(column);
    struct ray_list kinds[3] = {{0}, {0}, {0}};
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = sphere->vertices,
                      .vertex_count = VERTEX_COUNT,
                      .indices = sphere->indices,
                      .triangle_count = TRIANGLE_COUNT};
    struct fixture fixture = {.tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH),
                              .kdtree = build_structure(&mesh, 1, MLRT_STRUCTURE_KDTREE)};
    size_t misses[4] = {0}, way_count = 0;
    const uint32_t side = step == 1 ? FACE_SIDE : FACE_SIDE / 8;
    list_rays(sphere, column, step, kinds);
    for (size_t v = 0; v < variant_count(); v++) {
        const struct variant *variant = variant_at(v);
        if (!variant->probe && variant->options.method != MLRT_METHOD_RAY) continue;
        const mlrt_tree *tree = variant_tree(variant, &fixture);
        for (int kind = 0; kind < 3; kind++) misses[kind] += count_misses(tree, &kinds[kind], variant);
        misses[3] += count_missed_pixels(tree, sphere->inside, variant, side);
        way_count++;
    }
    if (verbose)
        printf("%-24s %7zu %7zu %7zu rays, %zu ways x 3: misses %zu / %zu / %zu; %u pixels: %zu\n", column->name,
               kinds[0].count, kinds[1].count, kinds[2].count, way_count, misses[0], misses[1], misses[2],
               (unsigned)(6 * side * side), misses[3]);
    fflush(stdout);
    for (int kind = 0; kind < 3; kind++) free_rays(&kinds[kind]);
    mlrt_destroy_tree(fixture.tree);
    mlrt_destroy_tree(fixture.kdtree);
    free(sphere);
    return misses[0] + misses[1] + misses[2] + misses[3];
}

static void no_ray_leaves_the_sphere(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof columns / sizeof columns[0]; i += SANITIZED ? 3 : 1) {
        size_t misses = run_column(&columns[i], SANITIZED ? 4096 : 512, 0);
        if (misses) fail_msg("sphere, %s: %zu misses (test_stability --sphere says more)", columns[i].name, misses);
    }
}

static int run_sphere(void)
{
    size_t misses = 0;
    for (size_t i = 0; i < sizeof columns / sizeof columns[0]; i++) misses += run_column(&columns[i], 1, 1);
    printf("misses in all: %zu\n", misses);
    return misses != 0;
}

/* ---- programs ---------------------------------------------------------------------------------------------------- */

static int run_scenes_by_arguments(int argc, char **argv)
{
    const char *only = NULL;
    double product = 1e9, seconds = INFINITY;
    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--only") == 0 && i + 1 < argc)
            only = argv[++i];
        else if (strcmp(argv[i], "--seconds") == 0 && i + 1 < argc)
            seconds = strtod(argv[++i], NULL);
        else
            product = strtod(argv[i], NULL);
    }
    return run_scenes(product, seconds, only);
}

int main(int argc, char **argv)
{
    const char *what = argc > 1 ? argv[1] : "";
    if (strcmp(what, "--list") == 0) {
        list_scenes();
        return 0;
    }
    if (strcmp(what, "--scenes") == 0) return run_scenes_by_arguments(argc, argv);
    if (strcmp(what, "--worlds") == 0)
        return run_worlds(argc > 2 ? strtoull(argv[2], NULL, 10) : 1000, argc > 3 ? strtoull(argv[3], NULL, 10) : 0);
    if (strcmp(what, "--sphere") == 0) return run_sphere();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_case_has_a_scene_or_a_ray),
        cmocka_unit_test(every_hard_scene),
        cmocka_unit_test(worlds_of_every_scene),
        cmocka_unit_test(no_ray_leaves_the_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
