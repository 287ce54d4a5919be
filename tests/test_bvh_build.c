/* SPDX-License-Identifier: MIT */
/*
 * Whole hierarchies of boxes: every one must keep the invariants of bvh/node.h (check_bvh), whatever the triangles are,
 * and be the same for any number of threads.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>

#include "bvh/node.h"
#include "job/structure.h"
#include "invariants.h"
#include "support.h"

/* ---- helpers ------------------------------------------------------------------------------------------------- */

static mlrt_tree_options options_of(int32_t preset)
{
    mlrt_tree_options options;
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.preset = preset;
    return options;
}

static const int32_t PRESETS[] = {MLRT_TREE_FAST, MLRT_TREE_DEFAULT, MLRT_TREE_BEST};

#define PRESET_COUNT (sizeof PRESETS / sizeof *PRESETS)

static void free_hierarchy(struct mlrt_tree *tree)
{
    mlrt_free_bvh(tree);
    assert_int_equal(tree->memory.held_size, 0);
}

static struct mlrt_triangle *triangles_of(const struct soup *soup)
{
    return (struct mlrt_triangle *)(void *)soup->corners;
}

/* Builds (options NULL = default), checks, and leaves the hierarchy to look at. The triangles stay the caller's. */
static struct mlrt_tree build_with(struct mlrt_triangle *triangles, uint32_t count, const mlrt_tree_options *options)
{
    struct mlrt_tree tree;
    const mlrt_tree_options defaults = options_of(MLRT_TREE_DEFAULT);
    memset(&tree, 0, sizeof tree);
    tree.triangles = triangles;
    mlrt_find_triangles(&tree);
    tree.triangle_count = count;
    assert_int_equal(mlrt_build_bvh(&tree, options ? options : &defaults, NULL), MLRT_OK);
    const char *wrong = check_bvh(&tree);
    if (wrong != NULL) fail_msg("%s", wrong);
    return tree;
}

/* References that a preset allows for, as mlrt.h has it. */
static uint64_t reference_limit(int32_t preset, uint32_t count)
{
    return preset == MLRT_TREE_FAST ? count : preset == MLRT_TREE_BEST ? count + count / 2 : count + count * 15u / 100;
}

/* Builds with all presets; returns the default one's report. */
static mlrt_tree_info build_and_check(struct mlrt_triangle *triangles, uint32_t count)
{
    mlrt_tree_info info;
    memset(&info, 0, sizeof info);
    for (size_t i = 0; i < PRESET_COUNT; i++) {
        mlrt_tree_options options = options_of(PRESETS[i]);
        struct mlrt_tree tree = build_with(triangles, count, &options);
        if (PRESETS[i] == MLRT_TREE_DEFAULT) info = tree.info;
        assert_true(tree.info.depth <= MLRT_BVH_DEPTH_LIMIT);
        assert_true(tree.info.reference_count <= reference_limit(PRESETS[i], count));
        free_hierarchy(&tree);
    }
    return info;
}

static mlrt_tree_info check_soup(struct soup *soup)
{
    mlrt_tree_info info = build_and_check(triangles_of(soup), (uint32_t)soup->count);
    free_soup(soup);
    return info;
}

/* ---- small inputs -------------------------------------------------------------------------------------------- */

static void test_no_triangles_make_no_nodes(void **state)
{
    (void)state;
    struct mlrt_tree tree = build_with(NULL, 0, NULL);
    assert_int_equal(tree.bvh.node_count, 0);
    assert_int_equal(tree.info.node_count, 0);
    assert_int_equal(tree.info.leaf_count, 0);
    assert_true(tree.bounds.lo[0] == 0 && tree.bounds.hi[2] == 0);
    assert_true(tree.bvh.unit == 1);
    free_hierarchy(&tree);
}

static void test_one_triangle(void **state)
{
    (void)state;
    struct mlrt_triangle triangle = {{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}};
    struct mlrt_tree tree = build_with(&triangle, 1, NULL);
    assert_int_equal(tree.bvh.node_count, 1);
    assert_int_equal(tree.bvh.quad_count, 1);
    assert_true(tree.bvh.nodes[0].lo[2][0] == 5 && tree.bvh.nodes[0].hi[0][0] == 1);
    assert_int_equal(tree.bvh.numbers[0], 0);
    assert_true(isnan(tree.bvh.corners[1]));
    assert_int_equal(tree.info.depth, 1);
    assert_true(tree.bounds.hi[0] == 1 && tree.info.bounds_max[2] == 5);
    free_hierarchy(&tree);
}

static void test_numbers_of_triangles_from_1_to_40(void **state)
{
    (void)state;
    struct random random = {1};
    for (uint32_t count = 1; count <= 40; count++) {
        struct soup soup = {0};
        soup_add_random(&soup, &random, count, 1, 0.1f);
        mlrt_tree_info info = check_soup(&soup);
        assert_true(info.reference_count >= count);
    }
}

static void test_triangles_that_cannot_be_hit_are_counted_and_left_out(void **state)
{
    (void)state;
    struct random random = {2};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 300, 1, 0.2f);
    struct mlrt_triangle *triangles = triangles_of(&soup);
    for (int i = 0; i < 300; i += 3) {
        if (i % 2 == 0)
            triangles[i].v[1][i % 4 / 2] = i % 4 == 0 ? NAN : -INFINITY;
        else
            memcpy(triangles[i].v[2], triangles[i].v[1], sizeof triangles[i].v[1]);
    }
    mlrt_tree_info info = check_soup(&soup);
    assert_int_equal(info.non_finite_count, 50);
    assert_int_equal(info.zero_area_count, 50);
}

static void test_only_triangles_that_cannot_be_hit(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[20];
    for (int i = 0; i < 20; i++)
        for (int j = 0; j < 9; j++) triangles[i].v[j / 3][j % 3] = i % 2 == 0 ? NAN : 1;
    struct mlrt_tree tree = build_with(triangles, 20, NULL);
    assert_int_equal(tree.info.non_finite_count, 10);
    assert_int_equal(tree.info.zero_area_count, 10);
    assert_int_equal(tree.bvh.node_count, 0);
    free_hierarchy(&tree);
}

/* ---- inputs that hurt ---------------------------------------------------------------------------------------- */

static void check_identical(uint32_t count)
{
    struct mlrt_triangle *triangles = malloc(count * sizeof *triangles);
    for (uint32_t i = 0; i < count; i++) triangles[i] = (struct mlrt_triangle){{{1, 2, 3}, {2, 2, 3}, {1, 3, 4}}};
    build_and_check(triangles, count);
    free(triangles);
}

static void test_identical_triangles(void **state)
{
    (void)state;
    check_identical(16);
    check_identical(17);
    check_identical(257);
    check_identical((uint32_t)scaled(2500));
}

static void test_needles(void **state)
{
    (void)state;
    struct random random = {3};
    struct soup soup = {0};
    soup_add_needles(&soup, &random, 2000, 1e4f);
    check_soup(&soup);
}

static void test_coplanar_triangles(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_grid(&soup, 2, -0.0f, 40);
    check_soup(&soup);
}

/* Each triangle half as far out as the one before: every split cuts off one, and a binary hierarchy would be a list. */
static void test_ever_smaller_triangles(void **state)
{
    (void)state;
    enum { COUNT = 2500 };
    static struct mlrt_triangle triangles[COUNT];
    for (int i = 0; i < COUNT; i++) {
        float size = ldexpf(1, 120 - i % 250);
        int axis = i / 250 % 3;
        memset(&triangles[i], 0, sizeof triangles[i]);
        for (int j = 0; j < 3; j++) triangles[i].v[j][axis] = size;
        triangles[i].v[1][(axis + 1) % 3] = size;
        triangles[i].v[2][(axis + 2) % 3] = size;
    }
    build_and_check(triangles, COUNT);
}

static void test_any_finite_coordinates(void **state)
{
    (void)state;
    enum { COUNT = 3000 };
    static struct mlrt_triangle triangles[COUNT];
    struct random random = {4};
    for (int i = 0; i < COUNT; i++)
        for (int j = 0; j < 9; j++) triangles[i].v[j / 3][j % 3] = draw_finite(&random);
    mlrt_tree_info info = build_and_check(triangles, COUNT);
    assert_true(isfinite(info.sah_cost) && info.sah_cost > 0);
}

static void check_scaled(float scale, float unit)
{
    struct random random = {5};
    struct soup soup = {0};
    const float offset[3] = {0, 0, 0};
    soup_add_random(&soup, &random, 1000, 1, 0.1f);
    move_soup(&soup, scale, offset);
    struct mlrt_tree tree = build_with(triangles_of(&soup), (uint32_t)soup.count, NULL);
    if (tree.bvh.unit != unit)
        fail_msg("times %a: unit %a, not %a", (double)scale, (double)tree.bvh.unit, (double)unit);
    free_hierarchy(&tree);
    check_soup(&soup);
}

static void test_huge_and_tiny_coordinates(void **state)
{
    (void)state;
    check_scaled(0x1p126f, 0x1p-120f);
    check_scaled(0x1p62f, 0x1p-62f);
    check_scaled(0x1p22f, 0x1p-22f);
    check_scaled(0x1p18f, 1);
    check_scaled(0x1p-18f, 1);
    check_scaled(0x1p-70f, 0x1p70f);
    check_scaled(0x1p-130f, 0x1p120f);
    check_scaled(0x1p-140f, 0x1p120f);
}

/* A wall of two triangles through a cloud of small ones: parts of it may be cut off. */
static void test_large_triangles_are_cut(void **state)
{
    (void)state;
    struct random random = {6};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 4000, 1, 0.01f);
    soup_add_random(&soup, &random, 100, 1, 2);
    mlrt_tree_info info = check_soup(&soup);
    assert_true(info.reference_count > 4100);
}

/* Cutting at any height, also through vertices and along edges, must leave no gap: check_bvh looks at edges. */
static void test_cut_triangles_that_share_edges(void **state)
{
    (void)state;
    struct random random = {8};
    struct soup soup = {0};
    const float offset[3] = {1000, -0.3f, 1e-3f};
    soup_add_grid(&soup, 0, 4, 8);
    soup_add_grid(&soup, 1, 4, 8);
    soup_add_grid(&soup, 2, 4, 2);
    soup_add_needles(&soup, &random, 200, 100);
    soup_add_random(&soup, &random, 3000, 8, 0.05f);
    move_soup(&soup, 0.7f, offset);
    check_soup(&soup);
}

/* ---- what is promised ---------------------------------------------------------------------------------------- */

static struct soup large_soup(void)
{
    struct random random = {7};
    struct soup soup = {0};
    soup_add_random(&soup, &random, scaled(30000), 1, 0.01f);
    soup_add_random(&soup, &random, scaled(1000), 1, 0.3f);
    soup_add_icosphere(&soup, 4, 0.7f);
    soup_add_grid(&soup, 1, 0.25f, 20);
    return soup;
}

static void test_threads_change_nothing(void **state)
{
    (void)state;
    struct soup soup = large_soup();
    for (size_t i = 0; i < PRESET_COUNT; i++) {
        mlrt_tree_options options = options_of(PRESETS[i]);
        struct mlrt_tree first = build_with(triangles_of(&soup), (uint32_t)soup.count, &options);
        for (uint32_t threads = 1; threads <= 4; threads++) {
            options.pool = shared_pool(threads);
            struct mlrt_tree tree = build_with(triangles_of(&soup), (uint32_t)soup.count, &options);
            assert_int_equal(tree.info.tree_hash, first.info.tree_hash);
            assert_int_equal(tree.bvh.node_count, first.bvh.node_count);
            assert_memory_equal(tree.bvh.nodes, first.bvh.nodes, tree.bvh.node_count * sizeof *tree.bvh.nodes);
            free_hierarchy(&tree);
        }
        free_hierarchy(&first);
    }
    free_soup(&soup);
}

static void test_running_out_of_memory_leaves_nothing(void **state)
{
    (void)state;
    struct soup soup = large_soup();
    soup.count = 3000;
    for (size_t i = 0; i < PRESET_COUNT; i++) {
        mlrt_tree_options options = options_of(PRESETS[i]);
        int32_t status = MLRT_ERROR_OUT_OF_MEMORY;
        uint32_t failure_count = 0;
        for (uint64_t limit = 1; status != MLRT_OK; limit += limit / 16 + 1) {
            struct mlrt_tree tree;
            memset(&tree, 0, sizeof tree);
            tree.memory.limit_size = limit;
            tree.triangles = triangles_of(&soup);
            mlrt_find_triangles(&tree);
            tree.triangle_count = (uint32_t)soup.count;
            status = mlrt_build_bvh(&tree, &options, NULL);
            if (status == MLRT_OK) {
                free_hierarchy(&tree);
                continue;
            }
            failure_count++;
            assert_int_equal(status, MLRT_ERROR_OUT_OF_MEMORY);
            assert_null(tree.bvh.nodes);
            assert_null(tree.bvh.corners);
            assert_null(tree.bvh.numbers);
            assert_int_equal(tree.memory.held_size, 0);
        }
        assert_true(failure_count > 50);
    }
    free_soup(&soup);
}

static void test_too_many_triangles(void **state)
{
    (void)state;
    struct mlrt_tree tree;
    const mlrt_tree_options defaults = options_of(MLRT_TREE_DEFAULT);
    memset(&tree, 0, sizeof tree);
    tree.triangle_count = 1u << 30;
    assert_int_equal(mlrt_build_bvh(&tree, &defaults, NULL), MLRT_ERROR_TOO_LARGE);
    assert_int_equal(tree.memory.held_size, 0);
}

static void test_the_report_is_filled(void **state)
{
    (void)state;
    struct soup soup = large_soup();
    mlrt_mesh mesh = soup_mesh(&soup);
    mlrt_tree_options options = options_of(MLRT_TREE_DEFAULT);
    mlrt_tree *tree;
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_OK);
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
    assert_ptr_equal(tree->structure, &mlrt_structure_bvh);
    assert_int_equal(info.structure, MLRT_STRUCTURE_BVH);
    assert_null(tree->kdtree.nodes);
    assert_int_equal(tree->kdtree.node_count, 0);
    assert_int_equal(info.triangle_count, soup.count);
    assert_int_equal(info.node_count, tree->bvh.node_count);
    assert_true(info.reference_count >= soup.count && info.leaf_count * 16 >= info.reference_count);
    assert_true(info.depth >= 3 && info.sah_cost > 1 && info.tree_hash != 0);
    assert_true(info.memory_size <= 100 * soup.count && info.peak_memory_size >= info.memory_size);
    assert_true(info.bounds_min[0] < 0 && info.bounds_max[0] > 0);
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_triangles_make_no_nodes),
        cmocka_unit_test(test_one_triangle),
        cmocka_unit_test(test_numbers_of_triangles_from_1_to_40),
        cmocka_unit_test(test_triangles_that_cannot_be_hit_are_counted_and_left_out),
        cmocka_unit_test(test_only_triangles_that_cannot_be_hit),
        cmocka_unit_test(test_identical_triangles),
        cmocka_unit_test(test_needles),
        cmocka_unit_test(test_coplanar_triangles),
        cmocka_unit_test(test_ever_smaller_triangles),
        cmocka_unit_test(test_any_finite_coordinates),
        cmocka_unit_test(test_huge_and_tiny_coordinates),
        cmocka_unit_test(test_large_triangles_are_cut),
        cmocka_unit_test(test_cut_triangles_that_share_edges),
        cmocka_unit_test(test_threads_change_nothing),
        cmocka_unit_test(test_running_out_of_memory_leaves_nothing),
        cmocka_unit_test(test_too_many_triangles),
        cmocka_unit_test(test_the_report_is_filled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
