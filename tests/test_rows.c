/* SPDX-License-Identifier: MIT */
/*
 * Rows of pixels are found in lists of rays where packets and tiles are narrower with them, and nothing is found where
 * they are not. Answers do not depend on it.
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
#include "scene/tree.h"
#include "support.h"

struct list {
    float (*points)[3];
    float (*directions)[3];
    uint32_t count;
};

static uint32_t found(const struct list *list)
{
    struct mlrt_tree tree;
    memset(&tree, 0, sizeof tree);
    for (int k = 0; k < 3; k++) tree.bounds.hi[k] = 4;
    struct mlrt_source source = {.kind = MLRT_SOURCE_RAYS, .count = list->count, .tree = &tree};
    source.arrays.points = (mlrt_const_array){list->points, 12};
    source.arrays.directions = (mlrt_const_array){list->directions, 12};
    return mlrt_find_row_length(&source);
}

/* The same for rays from a light to the points of the list. */
static uint32_t found_of_points(const struct list *list)
{
    struct mlrt_tree tree;
    memset(&tree, 0, sizeof tree);
    struct mlrt_source source = {.kind = MLRT_SOURCE_POINT_LIGHT, .count = list->count, .tree = &tree};
    source.arrays.points = (mlrt_const_array){list->points, 12};
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

/* A picture that is `field` wide at depth 1, rolled by a few degrees. */
struct view {
    uint32_t width;
    uint32_t height;
    float field;
};

/* Pixel (x, y) of a view, which need not be whole numbers. */
static void view_direction(const struct view *view, float x, float y, float direction[3])
{
    const float step = view->field / (float)view->width;
    const float u = (x - 0.5f * (float)view->width) * step, v = (y - 0.5f * (float)view->height) * step;
    direction[0] = u - 0.1f * v;
    direction[1] = 0.1f * u + v;
    direction[2] = 1;
}

static void make_unit_length(float d[3])
{
    const float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int k = 0; k < 3; k++) d[k] /= length;
}

/* Rows of pixels; unit vectors, or as the camera makes them. */
static void look(const struct view *view, int unit_length, struct list *list)
{
    make_list(view->width * view->height, list);
    for (uint32_t i = 0; i < list->count; i++) {
        view_direction(view, (float)(i % view->width), (float)(i / view->width), list->directions[i]);
        if (unit_length) make_unit_length(list->directions[i]);
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
    static const uint32_t widths[] = {40, 64, 100, 257, 1000};
    static const float fields[] = {0.01f, 0.8f, 3};
    for (size_t w = 0; w < sizeof widths / sizeof *widths; w++) {
        for (uint32_t variant = 0; variant < 3 * 2 * 2; variant++) {
            const struct view view = {widths[w], variant & 1 ? 33 : 16, fields[variant / 4]};
            struct list list;
            look(&view, variant >> 1 & 1, &list);
            assert_int_equal(found(&list), view.width);
            /* Of parallel rays the origins have rows. */
            for (uint32_t i = 0; i < list.count; i++) list.points[i][2] = 1;
            exchange(&list);
            assert_int_equal(found(&list), view.width);
            assert_int_equal(found_of_points(&list), view.width);
            free_list(&list);
        }
    }
}

/* Other orders of the pixels of a view, in lists whose packets and tiles are narrower with rows. */
static void test_other_orders_have_rows(void **state)
{
    (void)state;
    struct random random = {15};
    const struct view view = {120, 90, 1};
    const uint32_t width = view.width;
    struct list list;
    /* The beginning, the middle and the end of the picture, cut off anywhere; a pixel is missing. */
    look(&view, 0, &list);
    list.count -= 7;
    assert_int_equal(found(&list), width);
    for (uint32_t skipped = 1; skipped < 200; skipped += 18) {
        const struct list part = {list.points + skipped, list.directions + skipped, list.count - skipped};
        assert_int_equal(found(&part), width);
    }
    memmove(list.directions + 5678, list.directions + 5679, (list.count - 5679) * sizeof *list.directions);
    assert_int_equal(found(&list), width);
    free_list(&list);
    /* To and fro. */
    look(&view, 0, &list);
    for (uint32_t i = 0; i < list.count; i++) {
        const uint32_t x = i % width, y = i / width;
        view_direction(&view, (float)(y & 1 ? width - 1 - x : x), (float)y, list.directions[i]);
    }
    assert_int_equal(found(&list), 2 * width);
    free_list(&list);
    /* Four samples for each pixel. */
    make_list(4 * width * view.height, &list);
    for (uint32_t i = 0; i < list.count; i++) {
        const float x = (float)(i / 4 % width) + draw_range(&random, 0, 1);
        view_direction(&view, x, (float)(i / 4 / width) + draw_range(&random, 0, 1), list.directions[i]);
    }
    assert_int_equal(found(&list), 4 * width);
    free_list(&list);
    /* A panorama. */
    look(&view, 0, &list);
    for (uint32_t i = 0; i < list.count; i++) {
        const float a = 6.2831853f * (float)(i % width) / (float)width;
        const float b = 3.1415927f * ((float)(i / width) + 0.5f) / (float)view.height;
        const float d[3] = {sinf(b) * cosf(a), sinf(b) * sinf(a), cosf(b)};
        memcpy(list.directions[i], d, sizeof d);
    }
    assert_int_equal(found(&list), width);
    free_list(&list);
    /* From points of a wall to a light that is large; some points are missing. */
    look(&view, 0, &list);
    exchange(&list);
    for (uint32_t i = 0; i < list.count; i++) {
        for (int k = 0; k < 3; k++)
            list.directions[i][k] = (float)(k == 2) - list.points[i][k] + draw_range(&random, -0.1f, 0.1f);
        if (i % 50 == 20) list.points[i][1] = NAN;
    }
    assert_int_equal(found(&list), width);
    free_list(&list);
    /* From points of a lens. */
    look(&view, 0, &list);
    for (uint32_t i = 0; i < list.count; i++)
        for (int k = 0; k < 2; k++) list.points[i][k] = draw_range(&random, -0.01f, 0.01f);
    assert_int_equal(found(&list), width);
    free_list(&list);
    /* Blocks of 16 x 16 pixels. */
    const struct view blocks = {128, 96, 1};
    look(&blocks, 0, &list);
    for (uint32_t i = 0; i < list.count; i++) {
        const uint32_t block = i / 256, x = 16 * (block % 8) + i % 16, y = 16 * (block / 8) + i / 16 % 16;
        view_direction(&blocks, (float)x, (float)y, list.directions[i]);
    }
    assert_int_equal(found(&list), 16);
    free_list(&list);
}

/* The even bits of a number. */
static uint32_t even_bits(uint32_t number)
{
    uint32_t bits = 0;
    for (int i = 0; i < 16; i++) bits |= (number >> 2 * i & 1) << i;
    return bits;
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
    /* All the same; one row; three. */
    make_list(4096, &list);
    assert_int_equal(found(&list), 0);
    assert_int_equal(found_of_points(&list), 0);
    free_list(&list);
    for (uint32_t height = 1; height <= 3; height++) {
        const struct view view = {200, height, 1};
        look(&view, 0, &list);
        assert_int_equal(found(&list), 0);
        free_list(&list);
    }
    /* A Morton curve. */
    const struct view square = {128, 128, 1};
    look(&square, 0, &list);
    for (uint32_t i = 0; i < list.count; i++)
        view_direction(&square, (float)even_bits(i), (float)even_bits(i >> 1), list.directions[i]);
    assert_int_equal(found(&list), 0);
    free_list(&list);
    /* Sixteen samples for each pixel: a packet. */
    const struct view view = {60, 50, 1};
    make_list(16 * view.width * view.height, &list);
    for (uint32_t i = 0; i < list.count; i++) {
        const float x = (float)(i / 16 % view.width) + draw_range(&random, 0, 1);
        view_direction(&view, x, (float)(i / 16 / view.width) + draw_range(&random, 0, 1), list.directions[i]);
    }
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
        assert_true(found(&list) % length == 0 || list.count / length < 8);
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
        make_list(draw_below(&random, 600) + 1, &list);
        for (uint32_t i = 0; i < list.count; i++) {
            for (int k = 0; k < 3; k++) {
                const uint32_t bits = draw_bits(&random);
                memcpy(&list.directions[i][k], &bits, 4);
            }
        }
        const uint32_t length = found(&list);
        assert_true(length <= list.count / 4);
        assert_true(found_of_points(&list) <= list.count / 4);
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
    const struct view view = {WIDTH, HEIGHT, 1};
    look(&view, 1, &list);
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

/* The points of mlrt_occluded_points are looked at, too: as many boxes as with rows, other than as a list. */
static void test_points_have_rows(void **state)
{
    (void)state;
    static const float corners[3][3] = {{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    const mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT, .position = {0.1f, 0.2f, 3}};
    const struct view view = {48, 40, 2};
    static uint8_t occluded[3][48 * 40];
    uint64_t cells[3];
    struct list list;
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    look(&view, 0, &list);
    for (int i = 0; i < 3; i++) {
        mlrt_counters counters = {.struct_size = sizeof counters};
        const mlrt_trace_options options = {.struct_size = sizeof options, .counters = &counters};
        const uint32_t row_lengths[3] = {0, view.width, 4};
        const mlrt_points points = {.struct_size = sizeof points,
                                    .row_length = row_lengths[i],
                                    .count = list.count,
                                    .positions = {list.directions, 0}};
        const mlrt_array answers = {occluded[i], 0, 0};
        assert_int_equal(mlrt_occluded_points(tree, &points, &light, &options, &answers), MLRT_OK);
        cells[i] = counters.cell_count;
    }
    assert_memory_equal(occluded[0], occluded[1], sizeof occluded[0]);
    assert_memory_equal(occluded[0], occluded[2], sizeof occluded[0]);
    assert_int_equal(cells[0], cells[1]);
    assert_int_not_equal(cells[0], cells[2]);
    free_list(&list);
    mlrt_destroy_tree(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_have_rows),    cmocka_unit_test(test_other_orders_have_rows),
        cmocka_unit_test(test_other_lists_have_none), cmocka_unit_test(test_pieces_are_no_rows),
        cmocka_unit_test(test_any_numbers_will_do),   cmocka_unit_test(test_answers_stay_the_same),
        cmocka_unit_test(test_points_have_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
