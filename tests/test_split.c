/* SPDX-License-Identifier: MIT */
/*
 * Split rules, each on a cell small enough to see the answer.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

#include "mlrta/sort_keys.h"
#include "mlrta/split.h"

static const struct mlrt_box UNIT_BOX = {{0, 0, 0}, {1, 1, 1}};
static const struct mlrt_cost_model MODEL = {1, 1, 0.9};

static uint32_t next_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

static struct mlrt_reference reference_along_x(float lo, float hi)
{
    struct mlrt_reference reference = {0, {{lo, 0, 0}, {hi, 1, 1}}};
    return reference;
}

/* Two triangles that cover the unit square at x = position. */
static void make_wall(float position, struct mlrt_triangle triangles[2], struct mlrt_reference references[2],
                      uint32_t first)
{
    const struct mlrt_triangle wall[2] = {{{{position, 0, 0}, {position, 1, 0}, {position, 0, 1}}},
                                          {{{position, 1, 1}, {position, 1, 0}, {position, 0, 1}}}};
    for (uint32_t i = 0; i < 2; i++) {
        triangles[i] = wall[i];
        references[i] = reference_along_x(position, position);
        references[i].triangle = first + i;
    }
}

/* ---- keys ---------------------------------------------------------------------------------------------------- */

static void test_keys_order_like_floats(void **state)
{
    (void)state;
    const float ascending[] = {-3e38f, -1, -1e-45f, 0, 1e-45f, 1, 3e38f};
    for (size_t i = 1; i < sizeof ascending / sizeof ascending[0]; i++)
        assert_true(mlrt_float_key(ascending[i - 1]) < mlrt_float_key(ascending[i]));
}

static int compare_keys(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void test_sorting_agrees_with_qsort(void **state)
{
    (void)state;
    static uint32_t keys[5000], spare[5000], expected[5000];
    uint32_t seed = 1;
    for (size_t count = 0; count < 5000; count = count * 3 / 2 + 1)
        for (int bits = 2; bits <= 32; bits += 10) {
            for (size_t i = 0; i < count; i++)
                keys[i] = expected[i] = (next_random(&seed) ^ next_random(&seed) << 16) >> (32 - bits);
            qsort(expected, count, sizeof expected[0], compare_keys);
            mlrt_sort_keys(keys, spare, count);
            assert_memory_equal(keys, expected, count * sizeof keys[0]);
        }
}

/* ---- rule 1 -------------------------------------------------------------------------------------------------- */

static int find_empty_side(const struct mlrt_box *cell, const struct mlrt_box *bounds, struct mlrt_split *split)
{
    const struct mlrt_content content = {.cell = cell, .bounds = *bounds};
    return mlrt_find_empty_side(&content, split);
}

static void test_an_empty_side_over_ten_percent_is_found(void **state)
{
    (void)state;
    const struct mlrt_box content = {{0, 0.25f, 0}, {1, 1, 0.85f}};
    struct mlrt_split split;
    assert_true(find_empty_side(&UNIT_BOX, &content, &split));
    assert_int_equal(split.axis, 1);
    assert_true(split.position == 0.25f);
    assert_true(split.planar_above);
}

static void test_an_empty_side_of_less_is_not(void **state)
{
    (void)state;
    const struct mlrt_box content = {{0.09f, 0, 0}, {1, 0.91f, 1}};
    struct mlrt_split split;
    assert_false(find_empty_side(&UNIT_BOX, &content, &split));
}

static void test_a_flat_cell_has_no_empty_side(void **state)
{
    (void)state;
    const struct mlrt_box flat = {{0, 0.5f, 0}, {1, 0.5f, 1}};
    struct mlrt_split split;
    assert_false(find_empty_side(&flat, &flat, &split));
}

/* ---- rule 2 -------------------------------------------------------------------------------------------------- */

static int find_wall(const struct mlrt_triangle *triangles, const struct mlrt_reference *references, size_t count,
                     const struct mlrt_box *cell, struct mlrt_split *split)
{
    uint32_t keys[64];
    double areas[32];
    const struct mlrt_content content = mlrt_measure_content(cell, references, count, NULL);
    return mlrt_find_covered_plane(triangles, &content, keys, areas, split);
}

static void test_a_wall_is_found_and_goes_to_the_smaller_cell(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[2];
    struct mlrt_reference references[2];
    struct mlrt_split split;
    make_wall(0.25f, triangles, references, 0);
    assert_true(find_wall(triangles, references, 2, &UNIT_BOX, &split));
    assert_true(split.axis == 0 && split.position == 0.25f && !split.planar_above);
    make_wall(0.75f, triangles, references, 0);
    assert_true(find_wall(triangles, references, 2, &UNIT_BOX, &split));
    assert_true(split.position == 0.75f && split.planar_above);
}

static void test_a_wall_on_a_face_goes_to_a_flat_cell(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[2];
    struct mlrt_reference references[2];
    struct mlrt_split split;
    make_wall(0, triangles, references, 0);
    assert_true(find_wall(triangles, references, 2, &UNIT_BOX, &split));
    assert_true(split.position == 0 && !split.planar_above);
    make_wall(1, triangles, references, 0);
    assert_true(find_wall(triangles, references, 2, &UNIT_BOX, &split));
    assert_true(split.position == 1 && split.planar_above);
}

static void test_a_flat_cell_is_not_split_by_its_own_wall(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[2];
    struct mlrt_reference references[2];
    struct mlrt_split split;
    const struct mlrt_box flat = {{0.5f, 0, 0}, {0.5f, 1, 1}};
    make_wall(0.5f, triangles, references, 0);
    assert_false(find_wall(triangles, references, 2, &flat, &split));
}

static void test_half_a_wall_is_no_wall(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[2];
    struct mlrt_reference references[2];
    struct mlrt_split split;
    make_wall(0.5f, triangles, references, 0);
    assert_false(find_wall(triangles, references, 1, &UNIT_BOX, &split));
}

static void test_of_two_walls_the_middle_one_is_taken(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[4];
    struct mlrt_reference references[4];
    struct mlrt_split split;
    make_wall(0.1f, triangles, references, 0);
    make_wall(0.6f, triangles + 2, references + 2, 2);
    assert_true(find_wall(triangles, references, 4, &UNIT_BOX, &split));
    assert_true(split.position == 0.6f);
}

static void test_a_slanted_triangle_that_touches_a_face_is_no_wall(void **state)
{
    (void)state;
    const struct mlrt_triangle triangles[1] = {{{{0, -9, 0}, {0, 9, 0}, {1, 0, 9}}}};
    const struct mlrt_reference references[1] = {reference_along_x(0, 0)};
    struct mlrt_split split;
    assert_false(find_wall(triangles, references, 1, &UNIT_BOX, &split));
}

/* ---- surface area heuristic ---------------------------------------------------------------------------------- */

/* The cheapest split of the unit cube, exactly. */
static void find_split(const struct mlrt_reference *references, size_t count, struct mlrt_split *split)
{
    uint32_t keys[12];
    const struct mlrt_content content = mlrt_measure_content(&UNIT_BOX, references, count, NULL);
    mlrt_find_exact_split(&MODEL, &content, keys, split);
}

/* The content of a cell that just holds it. */
static struct mlrt_content measure_tightly(const struct mlrt_reference *references, size_t count, struct mlrt_box *cell)
{
    struct mlrt_content content = mlrt_measure_content(cell, references, count, NULL);
    *cell = content.bounds;
    return content;
}

static void test_clusters_are_separated(void **state)
{
    (void)state;
    const struct mlrt_reference references[] = {reference_along_x(0, 0.1f), reference_along_x(0, 0.2f),
                                                reference_along_x(0.8f, 1), reference_along_x(0.9f, 1)};
    struct mlrt_split split;
    find_split(references, 4, &split);
    assert_int_equal(split.axis, 0);
    assert_true(split.position == 0.2f || split.position == 0.8f);
    assert_true(split.cost < 4);
}

static void test_references_that_fill_the_cell_have_no_split(void **state)
{
    (void)state;
    const struct mlrt_reference references[] = {{0, {{0, 0, 0}, {1, 1, 1}}}, {1, {{0, 0, 0}, {1, 1, 1}}}};
    struct mlrt_split split;
    find_split(references, 2, &split);
    assert_true(split.cost == HUGE_VAL);
}

static void test_a_face_is_a_split_only_for_planar_references(void **state)
{
    (void)state;
    const struct mlrt_reference references[] = {reference_along_x(0, 0), reference_along_x(0, 1)};
    struct mlrt_split split;
    find_split(references, 2, &split);
    assert_true(split.position == 0 && !split.planar_above);
    assert_int_equal(mlrt_side_of_split(&references[0], &split), -1);
    assert_int_equal(mlrt_side_of_split(&references[1], &split), 1);
    find_split(references + 1, 1, &split);
    assert_true(split.cost == HUGE_VAL);
}

static void test_the_cost_is_that_of_the_counts(void **state)
{
    (void)state;
    const struct mlrt_reference references[] = {reference_along_x(0, 0.5f), reference_along_x(0.5f, 1),
                                                reference_along_x(0.5f, 1)};
    struct mlrt_split split;
    find_split(references, 3, &split);
    assert_true(split.position == 0.5f);
    assert_true(fabs(split.cost - (1 + 3 * 2.0 / 3)) < 1e-12);
}

static void fill_randomly(struct mlrt_reference *references, size_t count, uint32_t seed)
{
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            float lo = (float)next_random(&seed) * 0x1p-24f, size = (float)next_random(&seed) * 0x1p-30f;
            references[i].triangle = (uint32_t)i;
            references[i].box.lo[k] = lo * lo;
            references[i].box.hi[k] = fminf(lo * lo + (next_random(&seed) % 8 ? size : 0), 1);
        }
}

static void test_bins_find_nearly_the_best_split(void **state)
{
    (void)state;
    static struct mlrt_reference references[3000];
    static uint32_t keys[9000];
    for (uint32_t seed = 1; seed <= 20; seed++) {
        struct mlrt_split exact, binned;
        fill_randomly(references, 3000, seed);
        struct mlrt_box cell;
        const struct mlrt_content content = measure_tightly(references, 3000, &cell);
        mlrt_find_exact_split(&MODEL, &content, keys, &exact);
        mlrt_find_binned_split(&MODEL, &content, keys, &binned);
        assert_true(binned.cost >= exact.cost);
        assert_true(binned.cost <= 1.01 * exact.cost);
    }
}

/* The cost that a split was found with is the one of the references that it really separates. */
static void test_the_counts_of_bins_are_exact(void **state)
{
    (void)state;
    static struct mlrt_reference references[3000];
    static uint32_t keys[9000];
    for (uint32_t seed = 21; seed <= 40; seed++) {
        struct mlrt_split split;
        size_t below = 0, above = 0;
        fill_randomly(references, 3000, seed);
        struct mlrt_box cell;
        const struct mlrt_content content = measure_tightly(references, 3000, &cell);
        struct mlrt_box lower = content.bounds, upper = content.bounds;
        mlrt_find_binned_split(&MODEL, &content, keys, &split);
        for (size_t i = 0; i < 3000; i++) {
            below += mlrt_side_of_split(&references[i], &split) <= 0;
            above += mlrt_side_of_split(&references[i], &split) >= 0;
        }
        lower.hi[split.axis] = upper.lo[split.axis] = split.position;
        double cost = 1 + (mlrt_half_area(&lower) * (double)below + mlrt_half_area(&upper) * (double)above) /
                              mlrt_half_area(&content.bounds);
        assert_true(fabs(split.cost - cost) < 1e-9 * cost);
    }
}

static void test_bins_give_way_to_the_sweep_where_extents_collapse(void **state)
{
    (void)state;
    static struct mlrt_reference references[100];
    uint32_t keys[300];
    struct mlrt_split split;
    for (int i = 0; i < 100; i++) references[i] = reference_along_x((float)i * 1e-30f, (float)(i + 1) * 1e-30f);
    references[0] = reference_along_x(0, 1e30f);
    struct mlrt_box cell;
    const struct mlrt_content content = measure_tightly(references, 100, &cell);
    mlrt_find_binned_split(&MODEL, &content, keys, &split);
    assert_true(split.position > 0 && split.position <= 1.1e-28f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_keys_order_like_floats),
        cmocka_unit_test(test_sorting_agrees_with_qsort),
        cmocka_unit_test(test_an_empty_side_over_ten_percent_is_found),
        cmocka_unit_test(test_an_empty_side_of_less_is_not),
        cmocka_unit_test(test_a_flat_cell_has_no_empty_side),
        cmocka_unit_test(test_a_wall_is_found_and_goes_to_the_smaller_cell),
        cmocka_unit_test(test_a_wall_on_a_face_goes_to_a_flat_cell),
        cmocka_unit_test(test_a_flat_cell_is_not_split_by_its_own_wall),
        cmocka_unit_test(test_half_a_wall_is_no_wall),
        cmocka_unit_test(test_of_two_walls_the_middle_one_is_taken),
        cmocka_unit_test(test_a_slanted_triangle_that_touches_a_face_is_no_wall),
        cmocka_unit_test(test_clusters_are_separated),
        cmocka_unit_test(test_references_that_fill_the_cell_have_no_split),
        cmocka_unit_test(test_a_face_is_a_split_only_for_planar_references),
        cmocka_unit_test(test_the_cost_is_that_of_the_counts),
        cmocka_unit_test(test_bins_find_nearly_the_best_split),
        cmocka_unit_test(test_the_counts_of_bins_are_exact),
        cmocka_unit_test(test_bins_give_way_to_the_sweep_where_extents_collapse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
