/* SPDX-License-Identifier: MIT */
/*
 * See tally.h.
 */
#include "tally.h"

#include "hostile_rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define PRINTED_LIMIT 5
#define SINGLE_COUNT  64 /* at most: calls of one ray for each list and way */

/* ---- ways -------------------------------------------------------------------------------------------------------- */

/* One ray at a time is the same code for every instruction set; of the others, the probes. */
static int is_compared(size_t variant)
{
    const mlrt_trace_options *options = &variant_at(variant)->options;
    if (options->method == MLRT_METHOD_RAY) return options->isa == narrowest_isa();
    return variant_at(variant)->probe && options->isa != MLRT_ISA_AUTO;
}

size_t tally_way_count(void)
{
    size_t count = 0;
    for (size_t v = 0; v < variant_count(); v++) count += is_compared(v) != 0;
    return count;
}

static mlrt_trace_options options_of(size_t variant)
{
    mlrt_trace_options options = variant_at(variant)->options;
    options.pool = shared_pool(variant_at(variant)->threads);
    return options;
}

/* ---- counting ---------------------------------------------------------------------------------------------------- */

static double processor_seconds(void)
{
    return (double)clock() / (double)CLOCKS_PER_SEC;
}

static void note(struct tally *tally, const struct fixture *fixture, const char *call, size_t variant, size_t index,
                 const struct reference_ray *ray, const struct reference_hit *expected, const struct reference_hit *got)
{
    char text[200];
    if (tally->difference_count++ >= PRINTED_LIMIT) return;
    describe(call, &variant_at(variant)->options, variant_at(variant)->threads, text, sizeof text);
    print_difference(fixture, text, index, ray, expected, got);
}

static void compare_hits(struct tally *tally, const struct fixture *fixture, const char *call, size_t variant,
                         const struct ray_list *list, const struct reference_hit *expected,
                         const struct reference_hit *got)
{
    tally->answer_count += list->count;
    for (size_t i = 0; i < list->count; i++) {
        if (!same_hit(&expected[i], &got[i]))
            note(tally, fixture, call, variant, i, &list->rays[i], &expected[i], &got[i]);
    }
}

static void compare_any(struct tally *tally, const struct fixture *fixture, const char *call, size_t variant,
                        const struct ray_list *list, const struct reference_hit *expected, const uint8_t *got)
{
    tally->answer_count += list->count;
    for (size_t i = 0; i < list->count; i++) {
        struct reference_hit answer = {.mesh = got[i] ? 0 : MLRT_NONE};
        if (got[i] != (expected[i].mesh != MLRT_NONE))
            note(tally, fixture, call, variant, i, &list->rays[i], &expected[i], &answer);
    }
}

static struct reference_hit *judge(struct tally *tally, const struct fixture *fixture, const struct ray_list *list)
{
    struct reference_hit *expected = allocate_or_fail(list->count, sizeof *expected);
    double start = processor_seconds();
    trace_reference(fixture, list, expected);
    tally->reference_seconds += processor_seconds() - start;
    tally->ray_count += list->count;
    return expected;
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

static void tally_singles(struct tally *tally, const struct fixture *fixture, const struct ray_list *list,
                          const struct reference_hit *expected, size_t variant)
{
    const mlrt_tree *tree = variant_tree(variant_at(variant), fixture);
    const mlrt_trace_options closest = options_of(variant);
    mlrt_trace_options any = closest;
    any.query = MLRT_QUERY_ANY;
    for (size_t i = 0; i < list->count; i += list->count / SINGLE_COUNT + 1) {
        const struct reference_ray *ray = &list->rays[i];
        if (ray->t_max == 0) continue; // a single ray cannot say this: 0 means no limit there
        struct reference_hit got = trace_one(tree, ray, &closest);
        if (!same_hit(&expected[i], &got)) note(tally, fixture, "trace_ray", variant, i, ray, &expected[i], &got);
        got = trace_one(tree, ray, &any);
        if ((got.mesh == MLRT_NONE) != (expected[i].mesh == MLRT_NONE))
            note(tally, fixture, "trace_ray, any hit", variant, i, ray, &expected[i], &got);
        tally->answer_count += 2;
    }
}

void tally_rays(struct tally *tally, const struct fixture *fixture, const struct ray_list *list, int with_any_hit)
{
    struct reference_hit *expected = judge(tally, fixture, list);
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    mlrt_rays rays = public_rays(list);
    for (size_t v = 0; v < variant_count(); v++) {
        if (!is_compared(v)) continue;
        mlrt_trace_options options = options_of(v);
        mlrt_hits hits = public_hits(got, 0);
        memset(got, 0xA5, list->count * sizeof *got);
        double start = processor_seconds();
        assert_int_equal(mlrt_trace_packet(variant_tree(variant_at(v), fixture), &rays, &options, &hits), MLRT_OK);
        tally->library_seconds += processor_seconds() - start;
        compare_hits(tally, fixture, "trace_packet", v, list, expected, got);
        if (!is_kdtree_method(options.method)) tally_singles(tally, fixture, list, expected, v);
        if (!with_any_hit) continue;
        hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
        options.query = MLRT_QUERY_ANY;
        memset(occluded, 0xA5, list->count);
        start = processor_seconds();
        assert_int_equal(mlrt_trace_packet(variant_tree(variant_at(v), fixture), &rays, &options, &hits), MLRT_OK);
        tally->library_seconds += processor_seconds() - start;
        compare_any(tally, fixture, "trace_packet, any hit", v, list, expected, occluded);
    }
    free(expected);
    free(got);
    free(occluded);
}

/* ---- all hits ---------------------------------------------------------------------------------------------------- */

enum { LIST_CAPACITY = 4 };

static int same_lists(const struct reference_list_hit *expected, const struct reference_totals *expected_totals,
                      const struct list_element *got, const struct list_totals *got_totals)
{
    static const struct reference_list_hit miss = {{INFINITY, 0, 0, MLRT_NONE, MLRT_NONE, 0}, 0};
    int same = got_totals->total == expected_totals->hit_count &&
               got_totals->crossing_total == expected_totals->crossing_count;
    for (size_t j = 0; j < LIST_CAPACITY; j++) {
        const struct reference_list_hit *wanted = j < expected_totals->hit_count ? &expected[j] : &miss;
        same &= same_hit(&wanted->hit, &got[j].hit) && got[j].crossing == wanted->crossing;
    }
    return same;
}

void tally_lists(struct tally *tally, const struct fixture *fixture, const struct ray_list *list)
{
    struct list_element *elements = allocate_or_fail(list->count * LIST_CAPACITY, sizeof *elements);
    struct list_totals *totals = allocate_or_fail(list->count, sizeof *totals);
    const mlrt_tree *const trees[] = {fixture->tree, fixture->kdtree};
    const mlrt_rays rays = public_rays(list);
    const mlrt_hit_lists lists = public_lists(elements, totals, LIST_CAPACITY);
    for (size_t n = 0; n < 2; n++) {
        memset(elements, 0xA5, list->count * LIST_CAPACITY * sizeof *elements);
        memset(totals, 0xA5, list->count * sizeof *totals);
        assert_int_equal(mlrt_trace_all_hits(trees[n], &rays, NULL, &lists), MLRT_OK);
        for (size_t i = 0; i < list->count; i++) {
            struct reference_list_hit expected[LIST_CAPACITY];
            const struct list_element *got = &elements[i * LIST_CAPACITY];
            const struct reference_totals expected_totals =
                reference_trace_all(fixture->reference, &list->rays[i], expected, LIST_CAPACITY);
            tally->answer_count++;
            if (same_lists(expected, &expected_totals, got, &totals[i])) continue;
            if (tally->difference_count++ < PRINTED_LIMIT)
                print_difference(fixture, n ? "all hits, kd-tree" : "all hits", i, &list->rays[i], &expected[0].hit,
                                 &got[0].hit);
        }
    }
    free(elements);
    free(totals);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* What camera_rays writes must be the reference's rays, but that a NaN may have any bits. */
static void compare_camera_rays(struct tally *tally, const struct fixture *fixture, const mlrt_camera *camera,
                                const struct ray_list *list)
{
    float *origins = allocate_or_fail(list->count, 12), *directions = allocate_or_fail(list->count, 12);
    mlrt_array out_origins = {origins, 0, 0}, out_directions = {directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(camera, &out_origins, &out_directions), MLRT_OK);
    for (size_t i = 0; i < list->count; i++) {
        const struct reference_ray *ray = &list->rays[i];
        int same = 1;
        for (int k = 0; k < 3; k++) {
            uint32_t o = bits_of_float(origins[3 * i + (size_t)k]), d = bits_of_float(directions[3 * i + (size_t)k]);
            same &= o == bits_of_float(ray->origin[k]) || ray->origin[k] != ray->origin[k];
            same &= d == bits_of_float(ray->direction[k]) || ray->direction[k] != ray->direction[k];
        }
        if (!same && tally->difference_count++ < PRINTED_LIMIT)
            print_error("%s, seed %llu: camera_rays: ray %zu\n", fixture->name, (unsigned long long)fixture->seed, i);
    }
    tally->answer_count += list->count;
    free(origins);
    free(directions);
}

void tally_camera(struct tally *tally, const struct fixture *fixture, const mlrt_camera *camera)
{
    struct ray_list list = {0};
    uint32_t width, height;
    camera_crop(camera, &width, &height);
    add_camera_rays(&list, camera);
    compare_camera_rays(tally, fixture, camera, &list);
    tally_rays(tally, fixture, &list, 0);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list.count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list.count, 1);
    trace_reference(fixture, &list, expected);
    for (size_t v = 0; v < variant_count(); v++) {
        if (!is_compared(v)) continue;
        mlrt_trace_options options = options_of(v);
        mlrt_hits hits = public_hits(got, width);
        memset(got, 0xA5, list.count * sizeof *got);
        memset(occluded, 0xA5, list.count);
        double start = processor_seconds();
        assert_int_equal(mlrt_render_tiles(variant_tree(variant_at(v), fixture), camera, &options, &hits, NULL, NULL),
                         MLRT_OK);
        hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
        options.query = MLRT_QUERY_ANY;
        assert_int_equal(mlrt_render_tiles(variant_tree(variant_at(v), fixture), camera, &options, &hits, NULL, NULL),
                         MLRT_OK);
        tally->library_seconds += processor_seconds() - start;
        compare_hits(tally, fixture, "render_tiles", v, &list, expected, got);
        compare_any(tally, fixture, "render_tiles, any hit", v, &list, expected, occluded);
    }
    free(expected);
    free(got);
    free(occluded);
    free_rays(&list);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

void tally_points(struct tally *tally, const struct fixture *fixture, const float *points, const uint32_t *skip,
                  size_t count, const mlrt_light *light)
{
    struct ray_list list = {0};
    for (size_t i = 0; i < count; i++) add_shadow_ray(&list, points + 3 * i, skip + 2 * i, light);
    struct reference_hit *expected = judge(tally, fixture, &list);
    uint8_t *occluded = allocate_or_fail(count, 1);
    mlrt_points public_points = {
        .struct_size = sizeof public_points, .count = count, .positions = {points, 0}, .skip = {skip, 0}};
    mlrt_array answers = {occluded, 0, 0};
    for (size_t v = 0; v < variant_count(); v++) {
        if (!is_compared(v)) continue;
        mlrt_trace_options options = options_of(v);
        memset(occluded, 0xA5, count);
        double start = processor_seconds();
        assert_int_equal(
            mlrt_occluded_points(variant_tree(variant_at(v), fixture), &public_points, light, &options, &answers),
            MLRT_OK);
        tally->library_seconds += processor_seconds() - start;
        compare_any(tally, fixture, "occluded_points", v, &list, expected, occluded);
    }
    free(expected);
    free(occluded);
    free_rays(&list);
}

/* ---- everything, in batches -------------------------------------------------------------------------------------- */

#define BATCH_SIZE  4096
#define BATCH_COUNT 16 /* at least */
#define POINT_COUNT 512

static void tally_lights(struct tally *tally, const struct fixture *fixture, struct random *random, size_t count)
{
    float points[3 * POINT_COUNT];
    uint32_t skip[2 * POINT_COUNT];
    mlrt_light light = draw_hostile_light(random, fixture);
    if (count > POINT_COUNT) count = POINT_COUNT;
    draw_hostile_points(random, fixture, &light, count, points, skip);
    tally_points(tally, fixture, points, skip, count, &light);
}

static void tally_camera_if_good(struct tally *tally, const struct fixture *fixture, struct random *random,
                                 uint32_t side)
{
    mlrt_camera camera = draw_hostile_camera(random, fixture, side);
    mlrt_array nowhere = {NULL, 0, 0};
    if (mlrt_camera_rays(&camera, &nowhere, &nowhere) == MLRT_OK) tally_camera(tally, fixture, &camera);
}

static void tally_batch(struct tally *tally, const struct fixture *fixture, size_t size)
{
    struct random random = {fixture->seed};
    struct ray_list list = {0};
    uint32_t choice = draw_below(&random, 32);
    if (choice < 3) tally_camera_if_good(tally, fixture, &random, size < 1024 ? 7 : 1 + draw_below(&random, 96));
    if (choice == 3) tally_lights(tally, fixture, &random, size);
    add_hostile_rays(&list, &random, fixture, draw_hostile_kind(&random), size);
    tally_rays(tally, fixture, &list, draw_below(&random, 4) == 0);
    if (choice == 4) tally_lists(tally, fixture, &list);
    free_rays(&list);
}

void tally_hostile(struct tally *tally, const struct fixture *fixture, uint64_t ray_count, double seconds)
{
    double start = processor_seconds();
    uint64_t end = tally->ray_count + ray_count;
    struct fixture batch = *fixture;
    size_t size = ray_count < BATCH_COUNT * BATCH_SIZE ? (size_t)(ray_count / BATCH_COUNT + 1) : BATCH_SIZE;
    for (; tally->ray_count < end && processor_seconds() - start < seconds; batch.seed++)
        tally_batch(tally, &batch, size);
}
