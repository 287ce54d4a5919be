/* SPDX-License-Identifier: MIT */
/*
 * All hits of a ray: lists against the reference, bit for bit, at every capacity; and the parity of crossings, which
 * must say exactly which points are inside a closed mesh, also along rays through its vertices, edges and faces.
 */
#define _POSIX_C_SOURCE 200809L /* posix_memalign */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hard_scenes.h"
#include "hostile_rays.h"
#include "support.h"

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static void check_list(const struct fixture *fixture, const struct ray_list *list, size_t i,
                       const struct list_element *elements, uint32_t capacity, struct list_totals got)
{
    static const struct reference_hit miss = {INFINITY, 0, 0, MLRT_NONE, MLRT_NONE, 0};
    const struct reference_ray *ray = &list->rays[i];
    struct reference_list_hit *expected = allocate_or_fail(capacity, sizeof *expected);
    struct reference_totals totals = reference_trace_all(fixture->reference, ray, expected, capacity);
    for (size_t j = 0; j < capacity; j++) {
        const int is_hit = j < totals.hit_count;
        check_hit(fixture, "all hits", i, ray, is_hit ? &expected[j].hit : &miss, &elements[j].hit);
        if (elements[j].crossing == (is_hit && expected[j].crossing)) continue;
        print_difference(fixture, "all hits", i, ray, &expected[j].hit, &elements[j].hit);
        fail_msg("hit %zu: crossing %u", j, (unsigned)elements[j].crossing);
    }
    if (got.total != totals.hit_count || got.crossing_total != totals.crossing_count) {
        print_difference(fixture, "totals", i, ray, &miss, &miss);
        fail_msg("%s: %u hits, %u crossings, not %zu and %zu", fixture->name, (unsigned)got.total,
                 (unsigned)got.crossing_total, totals.hit_count, totals.crossing_count);
    }
    free(expected);
}

static void check_lists_of(const mlrt_tree *tree, const struct fixture *fixture, const struct ray_list *list,
                           uint32_t capacity, uint32_t threads)
{
    struct list_element *elements = allocate_or_fail(list->count * capacity, sizeof *elements);
    struct list_totals *totals = allocate_or_fail(list->count, sizeof *totals);
    memset(elements, 0xA5, list->count * capacity * sizeof *elements);
    memset(totals, 0xA5, list->count * sizeof *totals);
    mlrt_rays rays = public_rays(list);
    mlrt_hit_lists lists = public_lists(elements, totals, capacity);
    mlrt_trace_options options = {.struct_size = sizeof options, .pool = shared_pool(threads)};
    assert_int_equal(mlrt_trace_all_hits(tree, &rays, &options, &lists), MLRT_OK);
    for (size_t i = 0; i < list->count; i++) check_list(fixture, list, i, elements + i * capacity, capacity, totals[i]);
    free(elements);
    free(totals);
}

static void check_lists(const struct fixture *fixture, const struct ray_list *list, uint32_t capacity, uint32_t threads)
{
    check_lists_of(fixture->tree, fixture, list, capacity, threads);
    check_lists_of(fixture->kdtree, fixture, list, capacity, threads);
}

static void check_at_every_capacity(const struct fixture *fixture, const struct ray_list *list)
{
    static const uint32_t capacities[] = {0, 1, 3, 70};
    static const uint32_t threads[] = {0, 1, 2, 8};
    for (int i = 0; i < 4; i++) check_lists(fixture, list, capacities[i], threads[i]);
}

static void every_hard_scene(void **state)
{
    (void)state;
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct fixture fixture = make_hard_scene(i);
        struct random random = {1000 + i};
        struct ray_list list = {0};
        for (int part = 0; part < 3; part++)
            add_hostile_rays(&list, &random, &fixture, draw_hostile_kind(&random), scaled(10));
        if (list.count > scaled(160)) list.count = scaled(160);
        check_at_every_capacity(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

static void every_kind_of_ray(void **state)
{
    (void)state;
    struct random random = {2};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 300, 1, 0.7f);
    soup_add_grid(&soup, 2, 0.5f, 3);
    soup_add_grid(&soup, 2, 0.5f, 3);
    struct fixture fixture = fixture_of_soup("soup and sheets", 2, &soup);
    for (size_t kind = 0; kind < hostile_kind_count(); kind++) {
        struct ray_list list = {0};
        add_hostile_rays(&list, &random, &fixture, kind, scaled(100));
        check_at_every_capacity(&fixture, &list);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

static void the_first_of_all_is_the_closest(void **state)
{
    (void)state;
    struct random random = {3};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 300, 1, 0.5f);
    struct fixture fixture = fixture_of_soup("random", 3, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(600), -2, 2);
    struct list_element *elements = allocate_or_fail(list.count, sizeof *elements);
    struct list_totals *totals = allocate_or_fail(list.count, sizeof *totals);
    struct reference_hit *closest = allocate_or_fail(list.count, sizeof *closest);
    mlrt_rays rays = public_rays(&list);
    mlrt_hit_lists lists = public_lists(elements, totals, 1);
    mlrt_hits hits = public_hits(closest, 0);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_OK);
    assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, NULL, &hits), MLRT_OK);
    for (size_t i = 0; i < list.count; i++) {
        check_hit(&fixture, "first of all hits", i, &list.rays[i], &closest[i], &elements[i].hit);
        assert_int_equal(totals[i].total > 0, closest[i].mesh != MLRT_NONE);
    }
    free(elements);
    free(totals);
    free(closest);
    free_rays(&list);
    free_fixture(&fixture);
}

static void arrays_that_are_not_wanted(void **state)
{
    (void)state;
    struct random random = {4};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 100, 1, 0.7f);
    struct fixture fixture = fixture_of_soup("random", 4, &soup);
    add_aimed_rays(&list, &random, &fixture, 50, -2, 2);
    mlrt_rays rays = public_rays(&list);
    struct list_element elements[2 * 50];
    struct list_totals totals[50];
    for (int missing = 0; missing < 9; missing++) {
        struct list_element expected[2 * 50];
        struct list_totals expected_totals[50];
        memset(elements, 0xA5, sizeof elements);
        memset(totals, 0xA5, sizeof totals);
        memset(expected, 0xA5, sizeof expected);
        memset(expected_totals, 0xA5, sizeof expected_totals);
        mlrt_hit_lists all = public_lists(expected, expected_totals, 2), lists = public_lists(elements, totals, 2);
        mlrt_array *const arrays[] = {&lists.t,        &lists.u,        &lists.v,
                                      &lists.mesh,     &lists.triangle, &lists.facing,
                                      &lists.crossing, &lists.total,    &lists.crossing_total};
        mlrt_array *const whole[] = {&all.t,      &all.u,        &all.v,     &all.mesh,          &all.triangle,
                                     &all.facing, &all.crossing, &all.total, &all.crossing_total};
        arrays[missing]->data = NULL;
        whole[missing]->data = NULL;
        assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_OK);
        whole[missing]->data = NULL;
        assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &all), MLRT_OK);
        assert_memory_equal(elements, expected, sizeof elements);
        assert_memory_equal(totals, expected_totals, sizeof totals);
    }
    free_rays(&list);
    free_fixture(&fixture);
}

/* A host whose memory fails once, at the allocation `fail_at` (counted from 1), or from there on. */
struct failing_memory {
    uint32_t allocation_count;
    uint32_t fail_at;
    int goes_on_failing;
    uint32_t block_count;
};

static void *take_block(void *user, size_t size, size_t alignment)
{
    struct failing_memory *memory = user;
    const uint32_t number = ++memory->allocation_count;
    void *block = NULL;
    if (number == memory->fail_at || (number > memory->fail_at && memory->goes_on_failing)) return NULL;
    if (posix_memalign(&block, alignment, size) != 0) return NULL;
    ++memory->block_count;
    return block;
}

static void give_block(void *user, void *block, size_t size, size_t alignment)
{
    struct failing_memory *memory = user;
    (void)size;
    (void)alignment;
    --memory->block_count;
    free(block);
}

/*
 * The list of a ray through 300 sheets grows three times after it began: whichever of its allocations fails, and also
 * if the next one does not, the call says so, and a ray with hits missing is not written.
 */
static void memory_that_fails_is_never_a_list_without_hits(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    const float origin[3] = {0.25f, 0.25f, -1}, direction[3] = {0, 0, 1};
    for (int i = 0; i < 300; i++) {
        const float z = (float)i, a[3] = {0, 0, z}, b[3] = {1, 0, z}, c[3] = {0, 1, z};
        soup_add_triangle(&soup, a, b, c);
    }
    struct fixture fixture = fixture_of_soup("sheets", 13, &soup);
    add_ray(&list, origin, direction);
    const mlrt_rays rays = public_rays(&list);
    const mlrt_tree *const trees[] = {fixture.kdtree, fixture.tree};
    for (int way = 0; way < 4; way++) {
        struct failing_memory memory = {.goes_on_failing = way & 1};
        const mlrt_host host = {
            .struct_size = sizeof host, .user = &memory, .allocate = take_block, .free = give_block};
        const mlrt_trace_options options = {.struct_size = sizeof options, .host = &host};
        int32_t status = MLRT_ERROR_OUT_OF_MEMORY;
        while (status != MLRT_OK) {
            struct list_totals totals = {7, 7};
            const mlrt_hit_lists lists = public_lists(NULL, &totals, 0);
            memory.allocation_count = 0;
            ++memory.fail_at;
            status = mlrt_trace_all_hits(trees[way / 2], &rays, &options, &lists);
            assert_int_equal(memory.block_count, 0);
            if (memory.allocation_count < memory.fail_at) { // nothing failed
                assert_int_equal(status, MLRT_OK);
                assert_int_equal(totals.total, 300);
                continue;
            }
            assert_int_equal(status, MLRT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(totals.total, 7);
            assert_int_equal(totals.crossing_total, 7);
        }
        assert_true(memory.fail_at > 5); // the worker, 64 hits, 128, 256, 512; and then none
    }
    free_rays(&list);
    free_fixture(&fixture);
}

static void wrong_arguments(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    struct list_totals totals[1];
    const float origin[3] = {0, 0, 0}, direction[3] = {0, 0, 1};
    soup_add_icosphere(&soup, 0, 1);
    struct fixture fixture = fixture_of_soup("icosahedron", 5, &soup);
    add_ray(&list, origin, direction);
    mlrt_rays rays = public_rays(&list);
    mlrt_hit_lists lists = public_lists(NULL, totals, 0), unset = lists;
    unset.struct_size = 0;
    assert_int_equal(mlrt_trace_all_hits(NULL, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, NULL, NULL, &lists), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &unset), MLRT_ERROR_STRUCT_SIZE);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_OK);
    free_rays(&list);
    free_fixture(&fixture);
}

/* Each array by itself; strides, addresses and sizes that it cannot have. */
static void arrays_that_cannot_be(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    struct list_element element;
    struct list_totals totals;
    const float origin[3] = {0, 0, 0}, direction[3] = {0, 0, 1};
    soup_add_icosphere(&soup, 0, 1);
    struct fixture fixture = fixture_of_soup("icosahedron", 6, &soup);
    add_ray(&list, origin, direction);
    mlrt_rays rays = public_rays(&list);
    memset(&element, 0xA5, sizeof element);
    memset(&totals, 0xA5, sizeof totals);
    const struct list_element untouched = element;
    const struct list_totals untouched_totals = totals;
    for (int a = 0; a < 9; a++) {
        mlrt_hit_lists lists = public_lists(&element, &totals, 1);
        mlrt_array *const arrays[] = {&lists.t,        &lists.u,        &lists.v,
                                      &lists.mesh,     &lists.triangle, &lists.facing,
                                      &lists.crossing, &lists.total,    &lists.crossing_total};
        const mlrt_array good = *arrays[a];
        if (a != 6) { // bytes may be anywhere
            for (size_t wrong = 1; wrong < 4; wrong++) {
                arrays[a]->stride = wrong;
                assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
                arrays[a]->stride = 4 + wrong;
                assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
                *arrays[a] = good;
                arrays[a]->data = (unsigned char *)good.data + wrong;
                assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
                *arrays[a] = good;
            }
        }
        lists.capacity = 0;
        for (int other = 0; other < 7; other++) {
            if (other != a) arrays[other]->data = NULL;
        }
        if (a < 7) assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
    }
    assert_memory_equal(&element, &untouched, sizeof element);
    assert_memory_equal(&totals, &untouched_totals, sizeof totals);
    free_rays(&list);
    free_fixture(&fixture);
}

static void rays_and_options_that_cannot_be(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    struct list_totals totals;
    const float origin[3] = {0, 0, 0}, direction[3] = {0, 0, 1};
    soup_add_icosphere(&soup, 0, 1);
    struct fixture fixture = fixture_of_soup("icosahedron", 7, &soup);
    add_ray(&list, origin, direction);
    const mlrt_rays good = public_rays(&list);
    const mlrt_hit_lists lists = public_lists(NULL, &totals, 0);
    mlrt_rays rays = good;
    rays.struct_size--;
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_STRUCT_SIZE);
    rays = good;
    rays.origins.data = NULL;
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
    rays = good;
    rays.directions.stride = 2;
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
    rays = good;
    rays.count = (size_t)INT32_MAX + 1;
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_ERROR_TOO_LARGE);
    mlrt_counters counters = {.struct_size = 1};
    mlrt_trace_options options = {.struct_size = sizeof options - 1};
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &good, &options, &lists), MLRT_ERROR_STRUCT_SIZE);
    options.struct_size = sizeof options;
    options.counters = &counters;
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &good, &options, &lists), MLRT_ERROR_STRUCT_SIZE);
    free_rays(&list);
    free_fixture(&fixture);
}

/* No rays: nothing is read or written, whatever the capacity. */
static void no_rays_at_all(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_icosphere(&soup, 0, 1);
    struct fixture fixture = fixture_of_soup("icosahedron", 8, &soup);
    struct list_element element;
    struct list_totals totals;
    memset(&totals, 0xA5, sizeof totals);
    const struct list_totals untouched = totals;
    const mlrt_rays rays = {.struct_size = sizeof rays};
    const mlrt_hit_lists lists = public_lists(&element, &totals, UINT32_MAX);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_OK);
    assert_memory_equal(&totals, &untouched, sizeof totals);
    free_fixture(&fixture);
}

/*
 * Packed arrays that end at the end of a page: hit j of ray i is element i * capacity + j, and nothing else is written.
 */
static void packed_arrays(void **state)
{
    (void)state;
    const uint32_t capacity = 3;
    struct random random = {9};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 100, 1, 0.7f);
    struct fixture fixture = fixture_of_soup("random", 9, &soup);
    add_mixed_rays(&list, &random, &fixture, 300, -2, 2);
    struct list_element *elements = allocate_or_fail(list.count * capacity, sizeof *elements);
    struct list_totals *totals = allocate_or_fail(list.count, sizeof *totals);
    const mlrt_rays rays = public_rays(&list);
    const mlrt_hit_lists whole = public_lists(elements, totals, capacity);
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &whole), MLRT_OK);
    const mlrt_array *const wholes[] = {&whole.t,        &whole.u,        &whole.v,
                                        &whole.mesh,     &whole.triangle, &whole.facing,
                                        &whole.crossing, &whole.total,    &whole.crossing_total};
    for (int a = 0; a < 9; a++) {
        const size_t size = a == 6 ? 1 : 4, count = list.count * (a < 7 ? capacity : 1);
        unsigned char *const packed = allocate_guarded(count * size);
        mlrt_hit_lists lists = {.struct_size = sizeof lists, .capacity = a < 7 ? capacity : 0};
        mlrt_array *const arrays[] = {&lists.t,        &lists.u,        &lists.v,
                                      &lists.mesh,     &lists.triangle, &lists.facing,
                                      &lists.crossing, &lists.total,    &lists.crossing_total};
        arrays[a]->data = packed;
        assert_int_equal(mlrt_trace_all_hits(fixture.tree, &rays, NULL, &lists), MLRT_OK);
        for (size_t i = 0; i < count; i++)
            assert_memory_equal(packed + i * size, (unsigned char *)wholes[a]->data + i * wholes[a]->stride, size);
        free_guarded(packed, count * size);
    }
    free(elements);
    free(totals);
    free_rays(&list);
    free_fixture(&fixture);
}

/* More hits than lists begin with room for, each met in many leaves: lists are cleaned and grow, over and over. */
static void many_hits_in_many_leaves(void **state)
{
    (void)state;
    static const size_t layers[] = {1, 31, 32, 33, 63, 64, 65, 127, 128, 129, 500};
    const float direction[3] = {0.125f, 0.0625f, -1};
    for (size_t n = 0; n < sizeof layers / sizeof layers[0]; n++) {
        struct random random = {20 + n};
        struct soup soup = {0};
        struct ray_list list = {0};
        for (size_t i = 0; i < layers[n]; i++) { // around the axis, some of them equal
            const float z = (float)(i / 2), a[3] = {-9, -9, z}, b[3] = {9, -9, z + 0.5f}, c[3] = {0, 9, z - 0.5f};
            soup_add_triangle(&soup, a, b, c);
        }
        for (int i = 0; i < 300; i++) { // what makes leaves small
            float p[3][3], at[3];
            draw_point(&random, -4, 4, at);
            at[2] = draw_range(&random, 0, (float)layers[n] / 2);
            for (int corner = 0; corner < 3; corner++) {
                draw_point(&random, -0.25f, 0.25f, p[corner]);
                for (int k = 0; k < 3; k++) p[corner][k] += at[k];
            }
            soup_add_triangle(&soup, p[0], p[1], p[2]);
        }
        struct fixture fixture = fixture_of_soup("layers", 20 + n, &soup);
        for (int i = 0; i < 12; i++) {
            const float origin[3] = {(float)(i % 4 - 2), (float)(i / 4 - 1), (float)layers[n] + 5};
            const float level[3] = {1, 0.25f, i % 2 ? 0 : -0.03125f};
            add_ray(&list, origin, direction);
            if (i == 0) add_ray(&list, origin, level);
        }
        check_lists(&fixture, &list, (uint32_t)layers[n], 0);
        check_lists(&fixture, &list, 7, 0);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/* ---- inside and outside ------------------------------------------------------------------------------------------ */

/* Rays from the point that meet vertices, middles of edges and planes of faces exactly; along axes; and any others. */
static void add_rays_from(struct ray_list *list, struct random *random, const struct fixture *fixture,
                          const float point[3])
{
    size_t count = reference_triangle_count(fixture->reference);
    for (int i = 0; i < 40; i++) {
        const struct reference_triangle *triangle =
            reference_triangle_at(fixture->reference, draw_below(random, (uint32_t)count));
        const float *a = triangle->corner[i % 3], *b = triangle->corner[(i + 1) % 3];
        float middle[3], along[3], direction[3];
        for (int k = 0; k < 3; k++) middle[k] = 0.5f * a[k] + 0.5f * b[k];
        reference_difference(b, a, along);
        draw_point(random, -1, 1, direction);
        add_ray_towards(list, point, a);
        add_ray_towards(list, point, middle);
        add_ray(list, point, along); // parallel to a face, and in its plane if the point is
        add_ray(list, point, direction);
    }
    for (int n = 0; n < 27; n++) {
        const float direction[3] = {(float)(n % 3 - 1), (float)(n / 3 % 3 - 1),
                                    n / 9 == 1 ? -0.0f : (float)(n / 9 - 1)};
        if (n != 13) add_ray(list, point, direction);
    }
}

/* The point is inside an odd number of closed meshes, or an even one. */
static void check_parity(const struct fixture *fixture, const float point[3], int odd)
{
    struct random random = {fixture->seed};
    struct ray_list list = {0};
    add_rays_from(&list, &random, fixture, point);
    check_lists(fixture, &list, 3, 0);
    struct list_totals *totals = allocate_or_fail(list.count, sizeof *totals);
    mlrt_rays rays = public_rays(&list);
    mlrt_hit_lists lists = public_lists(NULL, totals, 0);
    assert_int_equal(mlrt_trace_all_hits(fixture->tree, &rays, NULL, &lists), MLRT_OK);
    for (size_t i = 0; i < list.count; i++) {
        if ((int)(totals[i].crossing_total % 2) == odd && totals[i].crossing_total <= totals[i].total) continue;
        const struct reference_ray *ray = &list.rays[i];
        fail_msg("%s: %u crossings of %u hits from (%a, %a, %a) along (%a, %a, %a)", fixture->name,
                 (unsigned)totals[i].crossing_total, (unsigned)totals[i].total, (double)ray->origin[0],
                 (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0], (double)ray->direction[1],
                 (double)ray->direction[2]);
    }
    free(totals);
    free_rays(&list);
}

static void inside_and_outside_of_a_cube(void **state)
{
    (void)state;
    const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
    struct soup soup = {0};
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("cube", 10, &soup);
    for (int n = 0; n < 125; n++) { // also in the planes of faces, and beyond
        const float point[3] = {(float)(n % 5 - 2), (float)(n / 5 % 5 - 2), (float)(n / 25 - 2)};
        float size = fmaxf(fabsf(point[0]), fmaxf(fabsf(point[1]), fabsf(point[2])));
        if (size != 1) check_parity(&fixture, point, size < 1);
    }
    free_fixture(&fixture);
}

static void inside_and_outside_of_a_sphere(void **state)
{
    (void)state;
    static const float points[][3] = {{0, 0, 0}, {0.1f, -0.2f, 0.3f}, {0.5f, 0, 0}, {2, 0, 0}, {-1.5f, 0.25f, 3}};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 3, 1);
    struct fixture fixture = fixture_of_soup("sphere", 11, &soup);
    for (int i = 0; i < 5; i++) check_parity(&fixture, points[i], i < 3);
    free_fixture(&fixture);
}

static void inside_and_outside_of_a_torus(void **state)
{
    (void)state;
    static const float points[][3] = {{1, 0, 0}, {0, -1, 0.03125f}, {0.7071f, 0.7071f, 0},
                                      {0, 0, 0}, {0, 0, 2},         {3, 0, 0}};
    struct soup soup = {0};
    soup_add_torus(&soup, 40, 24, 1, 0.25f);
    struct fixture fixture = fixture_of_soup("torus", 12, &soup);
    for (int i = 0; i < 6; i++) check_parity(&fixture, points[i], i < 3);
    free_fixture(&fixture);
}

/* The sphere with its vertices at random distances from its centre. */
static void inside_and_outside_of_a_star(void **state)
{
    (void)state;
    static const float points[][3] = {{0, 0, 0}, {0.0005f, 0, -0.0005f}, {5, 5, 5}, {0, 4, 0}};
    size_t index = 0;
    while (strcmp(hard_scene_at(index)->name, "star") != 0) index++;
    struct fixture fixture = make_hard_scene(index);
    for (int i = 0; i < 4; i++) check_parity(&fixture, points[i], i < 2);
    free_fixture(&fixture);
}

static void inside_and_outside_of_nested_boxes(void **state)
{
    (void)state;
    struct soup soup = {0};
    for (int i = 1; i <= 9; i++) {
        const float size = (float)i, lo[3] = {-size, -size, -size}, hi[3] = {size, size, size};
        soup_add_box(&soup, lo, hi);
    }
    struct fixture fixture = fixture_of_soup("nested boxes", 14, &soup);
    for (int i = 0; i <= 10; i++) {
        // Around it are 9 - i boxes, the planes of whose faces contain the point's other coordinates.
        const float point[3] = {0.5f + (float)i, (float)(i % 4), -(float)(i / 2)};
        check_parity(&fixture, point, (i < 9 ? 9 - i : 0) % 2);
    }
    free_fixture(&fixture);
}

static void inside_and_outside_at_every_scale(void **state)
{
    (void)state;
    static const float scales[] = {1e-38f, 1e-20f, 1e-6f, 1e6f, 1e20f, 1e37f};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        const float zero[3] = {0, 0, 0}, outside[3] = {2 * scales[i], 0, scales[i]};
        struct soup soup = {0};
        soup_add_icosphere(&soup, 1, 1);
        move_soup(&soup, scales[i], zero);
        struct fixture fixture = fixture_of_soup("scaled sphere", 15 + i, &soup);
        check_parity(&fixture, zero, 1);
        check_parity(&fixture, outside, 0);
        free_fixture(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_hard_scene),
        cmocka_unit_test(every_kind_of_ray),
        cmocka_unit_test(the_first_of_all_is_the_closest),
        cmocka_unit_test(arrays_that_are_not_wanted),
        cmocka_unit_test(memory_that_fails_is_never_a_list_without_hits),
        cmocka_unit_test(wrong_arguments),
        cmocka_unit_test(arrays_that_cannot_be),
        cmocka_unit_test(rays_and_options_that_cannot_be),
        cmocka_unit_test(no_rays_at_all),
        cmocka_unit_test(packed_arrays),
        cmocka_unit_test(many_hits_in_many_leaves),
        cmocka_unit_test(inside_and_outside_of_a_cube),
        cmocka_unit_test(inside_and_outside_of_a_sphere),
        cmocka_unit_test(inside_and_outside_of_a_torus),
        cmocka_unit_test(inside_and_outside_of_a_star),
        cmocka_unit_test(inside_and_outside_of_nested_boxes),
        cmocka_unit_test(inside_and_outside_at_every_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
