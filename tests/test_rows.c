/* SPDX-License-Identifier: MIT */
/*
 * Rows of pixels are found in lists of rays, and nothing is found where there are none. Answers do not depend on it.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "rays/rows.h"
#include "support.h"

struct list {
    float (*points)[3];
    float (*directions)[3];
    uint32_t count;
};

static uint32_t found(const struct list *list)
{
    struct mlrt_source source = {.kind = MLRT_SOURCE_RAYS, .count = list->count};
    source.arrays.points = (mlrt_const_array){list->points, 12};
    source.arrays.directions = (mlrt_const_array){list->directions, 12};
    return mlrt_find_row_length(&source);
}

static void make_list(uint32_t count, struct list *list)
{
    list->count = count;
    list->points = calloc(count, sizeof *list->points);
    list->directions = calloc(count, sizeof *list->directions);
    assert_non_null(list->points);
    assert_non_null(list->directions);
}

static void free_list(struct list *list)
{
    free(list->points);
    free(list->directions);
}

/* A view that is `field` wide at depth 1, rolled by a few degrees; unit vectors, or as the camera makes them. */
static void look(uint32_t width, uint32_t height, float field, int unit_length, struct list *list)
{
    make_list(width * height, list);
    for (uint32_t i = 0; i < list->count; i++) {
        const float step = field / (float)width;
        const float x = ((float)(i % width) - 0.5f * (float)width) * step;
        const float y = ((float)(i / width) - 0.5f * (float)height) * step;
        const float d[3] = {x - 0.1f * y, 0.1f * x + y, 1};
        const float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int k = 0; k < 3; k++) list->directions[i][k] = unit_length ? d[k] / length : d[k];
    }
}

static void exchange(struct list *list)
{
    float(*points)[3] = list->points;
    list->points = list->directions;
    list->directions = points;
}

static void test_pictures_have_rows(void **state)
{
    (void)state;
    static const uint32_t widths[] = {8, 9, 16, 40, 64, 100, 257};
    static const float fields[] = {0.01f, 0.8f, 3};
    for (size_t w = 0; w < sizeof widths / sizeof *widths; w++) {
        for (uint32_t variant = 0; variant < 3 * 2 * 2; variant++) {
            struct list list;
            look(widths[w], variant & 1 ? 33 : 8, fields[variant / 4], variant >> 1 & 1, &list);
            assert_int_equal(found(&list), widths[w]);
            /* Of parallel rays the origins have rows. */
            exchange(&list);
            assert_int_equal(found(&list), widths[w]);
            free_list(&list);
        }
    }
}

static void test_other_lists_have_none(void **state)
{
    (void)state;
    struct random random = {11};
    struct list list;
    for (uint32_t round = 0; round < scaled(3000); round++) {
        make_list(1 + draw_below(&random, 600), &list);
        for (uint32_t i = 0; i < list.count; i++) draw_point(&random, -1, 1, list.directions[i]);
        assert_int_equal(found(&list), 0);
        free_list(&list);
    }
    /* All the same; one row; three; the last one short; one pixel missing. */
    make_list(4096, &list);
    assert_int_equal(found(&list), 0);
    free_list(&list);
    for (uint32_t height = 1; height <= 3; height++) {
        look(100, height, 1, 0, &list);
        assert_int_equal(found(&list), 0);
        free_list(&list);
    }
    look(100, 40, 1, 0, &list);
    list.count -= 7;
    assert_int_equal(found(&list), 0);
    list.count += 7;
    memmove(list.directions + 1234, list.directions + 1235, (list.count - 1235) * sizeof *list.directions);
    assert_int_equal(found(&list), 0);
    free_list(&list);
}

/* Pieces of lines, all of one length, from anywhere. */
static void test_pieces_are_no_rows(void **state)
{
    (void)state;
    struct random random = {14};
    for (uint32_t round = 0; round < scaled(300); round++) {
        const uint32_t length = 8 + draw_below(&random, 60);
        struct list list;
        make_list(length * (4 + draw_below(&random, 40)), &list);
        float step[3];
        for (uint32_t i = 0; i < list.count; i++) {
            if (i % length == 0) draw_point(&random, -0.001f, 0.001f, step);
            if (i % length == 0) draw_point(&random, -1, 1, list.directions[i]);
            for (int k = 0; k < 3 && i % length; k++) list.directions[i][k] = list.directions[i - 1][k] + step[k];
        }
        assert_int_equal(found(&list), 0);
        free_list(&list);
    }
}

/* No list is too strange, or read beyond its end. */
static void test_any_numbers_will_do(void **state)
{
    (void)state;
    struct random random = {12};
    for (uint32_t round = 0; round < scaled(3000); round++) {
        struct list list;
        make_list(draw_below(&random, 200) + 1, &list);
        for (uint32_t i = 0; i < list.count; i++) {
            for (int k = 0; k < 3; k++) {
                const uint32_t bits = draw_bits(&random);
                memcpy(&list.directions[i][k], &bits, 4);
            }
        }
        const uint32_t length = found(&list);
        assert_true(length == 0 || list.count % length == 0);
        free_list(&list);
    }
}

/* What is found is used: as many packets as with rows, and the same answers. */
static void test_answers_stay_the_same(void **state)
{
    (void)state;
    enum { WIDTH = 48, HEIGHT = 20, COUNT = WIDTH * HEIGHT };
    struct random random = {13};
    struct list list;
    static float corners[200][3][3];
    for (size_t i = 0; i < 200; i++) {
        float center[3];
        draw_point(&random, -0.5f, 0.5f, center);
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++) corners[i][j][k] = center[k] + draw_range(&random, -0.1f, 0.1f) + (k == 2);
        }
    }
    const mlrt_mesh mesh = {
        .struct_size = sizeof mesh, .vertices = corners, .vertex_count = 600, .triangle_count = 200};
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    look(WIDTH, HEIGHT, 1, 1, &list);
    static float t[2][COUNT];
    static uint32_t triangles[2][COUNT];
    uint64_t cells[2];
    for (int with_rows = 0; with_rows < 2; with_rows++) {
        mlrt_counters counters = {.struct_size = sizeof counters};
        const mlrt_trace_options options = {.struct_size = sizeof options, .counters = &counters};
        const mlrt_rays rays = {.struct_size = sizeof rays,
                                .row_length = with_rows ? WIDTH : 0,
                                .count = COUNT,
                                .origins = {list.points, 0},
                                .directions = {list.directions, 0}};
        const mlrt_hits hits = {
            .struct_size = sizeof hits, .t = {t[with_rows], 0, 0}, .triangle = {triangles[with_rows], 0, 0}};
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        cells[with_rows] = counters.cell_count;
    }
    assert_memory_equal(t[0], t[1], sizeof t[0]);
    assert_memory_equal(triangles[0], triangles[1], sizeof triangles[0]);
    assert_true(cells[0] > 0);
    assert_int_equal(cells[0], cells[1]);
    free_list(&list);
    mlrt_destroy_tree(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_have_rows),    cmocka_unit_test(test_other_lists_have_none),
        cmocka_unit_test(test_pieces_are_no_rows),    cmocka_unit_test(test_any_numbers_will_do),
        cmocka_unit_test(test_answers_stay_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
