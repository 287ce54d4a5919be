/* SPDX-License-Identifier: MIT */
/*
 * Whole trees: every one must keep the invariants of kdtree.h (check_kdtree), whatever the triangles are.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>

#include "invariants.h"
#include "mlrta/kdtree.h"

#include "common/scene.h"
#include "support.h"

/* ---- helpers ------------------------------------------------------------------------------------------------- */

static uint32_t next_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

static float random_unit(uint32_t *seed)
{
    return (float)next_random(seed) * 0x1p-24f;
}

/* Those of the tuned tree, which most limits below are about. */
static mlrt_kdtree_options tuned_options(void)
{
    mlrt_kdtree_options options;
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.preset = MLRT_KDTREE_TUNED;
    return options;
}

static void free_tree(struct mlrt_tree *tree)
{
    mlrt_free(&tree->memory, tree->kdtree.nodes, tree->kdtree.node_count, sizeof *tree->kdtree.nodes);
    mlrt_free(&tree->memory, tree->kdtree.references, tree->kdtree.reference_count, sizeof *tree->kdtree.references);
    assert_int_equal(tree->memory.held_size, 0);
}

/* Builds (options NULL = tuned), checks, and leaves the tree to look at. The triangles stay the caller's. */
static struct mlrt_tree build_with(struct mlrt_triangle *triangles, uint32_t count, const mlrt_kdtree_options *options)
{
    struct mlrt_tree tree;
    const mlrt_kdtree_options tuned = tuned_options();
    memset(&tree, 0, sizeof tree);
    tree.triangles = triangles;
    mlrt_find_triangles(&tree);
    tree.triangle_count = count;
    assert_int_equal(mlrt_build_nodes(&tree, options ? options : &tuned, NULL), MLRT_OK);
    const char *wrong = check_kdtree(&tree);
    if (wrong != NULL) fail_msg("%s", wrong);
    return tree;
}

/* Builds with both presets; returns the tuned one's report. */
static mlrt_tree_info build_and_check(struct mlrt_triangle *triangles, uint32_t count)
{
    mlrt_kdtree_options options = tuned_options();
    options.preset = MLRT_KDTREE_PAPER;
    struct mlrt_tree paper = build_with(triangles, count, &options), tree = build_with(triangles, count, NULL);
    free_tree(&paper);
    free_tree(&tree);
    return tree.info;
}

static void set_triangle(struct mlrt_triangle *triangle, const float a[3], const float b[3], const float c[3])
{
    memcpy(triangle->v[0], a, sizeof triangle->v[0]);
    memcpy(triangle->v[1], b, sizeof triangle->v[1]);
    memcpy(triangle->v[2], c, sizeof triangle->v[2]);
}

/* Small triangles in the unit cube. */
static void make_soup(struct mlrt_triangle *triangles, uint32_t count, float size, uint32_t seed)
{
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            float middle = random_unit(&seed);
            for (int j = 0; j < 3; j++) triangles[i].v[j][k] = middle + size * (random_unit(&seed) - 0.5f);
        }
}

/* Faces of the boxes of a grid with whole coordinates: two triangles each, everything on shared planes. */
static uint32_t make_rooms(struct mlrt_triangle *triangles, int size, uint32_t seed)
{
    uint32_t count = 0;
    for (int cell = 0; cell < size * size * size; cell++)
        for (int axis = 0; axis < 3; axis++) {
            if (next_random(&seed) % 3 == 0) continue;
            int at[3] = {cell % size, cell / size % size, cell / size / size};
            float corner[4][3];
            for (int i = 0; i < 4; i++)
                for (int k = 0; k < 3; k++) {
                    int step = k == (axis + 1) % 3 ? i & 1 : k == (axis + 2) % 3 ? i >> 1 : 0;
                    corner[i][k] = (float)(at[k] + step);
                }
            set_triangle(&triangles[count++], corner[0], corner[1], corner[2]);
            set_triangle(&triangles[count++], corner[3], corner[1], corner[2]);
        }
    return count;
}

static uint64_t entry_limit(uint32_t count)
{
    return 8 * (uint64_t)count + 1024;
}

/* ---- small inputs -------------------------------------------------------------------------------------------- */

static void test_no_triangles_make_one_empty_leaf(void **state)
{
    (void)state;
    struct mlrt_tree tree = build_with(NULL, 0, NULL);
    assert_int_equal(tree.kdtree.node_count, 1);
    assert_true(mlrt_node_is_leaf(&tree.kdtree.nodes[0]));
    assert_int_equal(mlrt_leaf_count(&tree.kdtree.nodes[0]), 0);
    assert_true(tree.bounds.lo[0] == 0 && tree.bounds.hi[2] == 0);
    assert_int_equal(tree.info.empty_leaf_count, 1);
    assert_true(tree.kdtree.float_safe);
    free_tree(&tree);
}

static void test_one_triangle(void **state)
{
    (void)state;
    struct mlrt_triangle triangle = {{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}};
    struct mlrt_tree tree = build_with(&triangle, 1, NULL);
    assert_true(tree.bounds.hi[0] == 1 && tree.bounds.lo[2] == 5 && tree.bounds.hi[2] == 5);
    free_tree(&tree);
    build_and_check(&triangle, 1);
}

static void test_triangles_that_cannot_be_hit_are_counted_and_left_out(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[] = {
        {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},        {{{0, 0, NAN}, {1, 0, 0}, {0, 1, 0}}},
        {{{0, 0, 0}, {INFINITY, 0, 0}, {0, 1, 0}}}, {{{0, 0, 0}, {1, 0, 0}, {0, -INFINITY, 0}}},
        {{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}},        {{{9, 9, 9}, {9, 9, 9}, {9, 9, 9}}},
    };
    mlrt_tree_info info = build_and_check(triangles, 6);
    assert_int_equal(info.non_finite_count, 3);
    assert_int_equal(info.zero_area_count, 2);
    assert_true(info.bounds_max[0] == 1);
}

static void test_minus_zero_is_zero(void **state)
{
    (void)state;
    struct mlrt_triangle triangle = {{{-0.0f, -0.0f, 1}, {1, -0.0f, 1}, {-0.0f, 1, 1}}};
    struct mlrt_tree tree = build_with(&triangle, 1, NULL);
    assert_false(signbit(tree.bounds.lo[0]));
    free_tree(&tree);
}

/* ---- the same place many times ------------------------------------------------------------------------------- */

static void fill_with(struct mlrt_triangle *triangles, uint32_t count, const struct mlrt_triangle *triangle)
{
    for (uint32_t i = 0; i < count; i++) triangles[i] = *triangle;
}

static void check_identical(uint32_t count, const struct mlrt_triangle *triangle)
{
    struct mlrt_triangle *triangles = malloc(count * sizeof *triangles);
    fill_with(triangles, count, triangle);
    mlrt_tree_info info = build_and_check(triangles, count);
    assert_true(info.reference_count <= entry_limit(count));
    free(triangles);
}

static void test_identical_triangles(void **state)
{
    (void)state;
    const struct mlrt_triangle slanted = {{{0, 0, 0}, {1, 0, 2}, {0, 1, 3}}};
    const struct mlrt_triangle flat = {{{0, 4, 0}, {1, 4, 0}, {0, 4, 1}}};
    check_identical(60, &slanted);
    check_identical(60, &flat);
    check_identical(100000, &slanted);
    check_identical(100000, &flat);
}

static void test_a_fan_through_one_point(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[3000];
    uint32_t seed = 5;
    make_soup(triangles, 3000, 2, seed);
    for (int i = 0; i < 3000; i++)
        for (int k = 0; k < 3; k++) triangles[i].v[0][k] = 0.5f;
    mlrt_tree_info info = build_and_check(triangles, 3000);
    assert_true(info.reference_count <= entry_limit(3000));
}

static void test_one_huge_triangle_over_many_small_ones(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[3000];
    make_soup(triangles, 3000, 0.01f, 6);
    const struct mlrt_triangle huge = {{{-50, -50, -49}, {50, -49, 50}, {0, 100, 0.3f}}};
    triangles[1234] = huge;
    build_and_check(triangles, 3000);
}

/* ---- flat things --------------------------------------------------------------------------------------------- */

static void test_a_scene_flat_in_one_axis(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[2000];
    for (int axis = 0; axis < 3; axis++) {
        make_soup(triangles, 2000, 0.1f, 7);
        for (int i = 0; i < 2000; i++)
            for (int j = 0; j < 3; j++) triangles[i].v[j][axis] = 0.7f;
        mlrt_tree_info info = build_and_check(triangles, 2000);
        assert_true(info.leaf_count > 100);
    }
}

static void test_walls_on_the_faces_of_cells(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[6000];
    uint32_t count = make_rooms(triangles, 9, 8);
    build_and_check(triangles, count);
}

/* A box of six walls: rule 2 puts them into flat cells, and the room inside is empty. */
static void test_a_room_has_flat_cells_and_an_empty_inside(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[12];
    uint32_t count = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int side = 0; side < 2; side++) {
            float corner[4][3];
            for (int i = 0; i < 4; i++) {
                corner[i][axis] = (float)side;
                corner[i][(axis + 1) % 3] = (float)(i & 1);
                corner[i][(axis + 2) % 3] = (float)(i >> 1);
            }
            set_triangle(&triangles[count++], corner[0], corner[1], corner[2]);
            set_triangle(&triangles[count++], corner[3], corner[1], corner[2]);
        }
    mlrt_kdtree_options options = tuned_options();
    options.intersection_cost = 10;
    struct mlrt_tree tree = build_with(triangles, 12, &options);
    assert_true(tree.info.empty_leaf_count >= 1);
    assert_int_equal(tree.kdtree.reference_count, 12);
    uint32_t node = 0;
    const float middle[3] = {0.5f, 0.5f, 0.5f};
    while (!mlrt_node_is_leaf(&tree.kdtree.nodes[node])) {
        const struct mlrt_node *inner = &tree.kdtree.nodes[node];
        node = mlrt_node_child(inner) + (middle[mlrt_node_axis(inner)] > inner->u.split);
    }
    assert_int_equal(mlrt_leaf_count(&tree.kdtree.nodes[node]), 0);
    free_tree(&tree);
}

/* ---- extreme numbers ----------------------------------------------------------------------------------------- */

static void test_extents_of_one_float(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[500];
    uint32_t seed = 9;
    for (int i = 0; i < 500; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) triangles[i].v[j][k] = next_random(&seed) % 2 ? 1 : nextafterf(1, 2);
    build_and_check(triangles, 500);
}

static void test_mixed_scales(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[1000];
    for (uint32_t seed = 10; seed < 16; seed++) {
        uint32_t random = seed;
        for (int i = 0; i < 1000; i++)
            for (int j = 0; j < 3; j++)
                for (int k = 0; k < 3; k++) {
                    int exponent = (int)(next_random(&random) % 277) - 149;
                    triangles[i].v[j][k] = ldexpf(random_unit(&random) - 0.5f, exponent);
                }
        build_and_check(triangles, 1000);
    }
}

static void test_the_largest_and_the_smallest_floats(void **state)
{
    (void)state;
    struct mlrt_triangle triangles[] = {
        {{{-FLT_MAX, -FLT_MAX, -FLT_MAX}, {FLT_MAX, FLT_MAX, -FLT_MAX}, {0, FLT_MAX, FLT_MAX}}},
        {{{1e-45f, 0, 0}, {0, 1e-45f, 0}, {0, 0, 1e-45f}}},
        {{{FLT_MAX, 0, 0}, {0, 1e-45f, 0}, {0, 0, FLT_MAX}}},
        {{{-1, -1, -1}, {1, -1, 1}, {0, 1, 0}}},
    };
    for (uint32_t count = 1; count <= 4; count++) build_and_check(triangles, count);
    build_and_check(triangles + 1, 1);
}

static void test_a_safe_scene_makes_a_safe_tree(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[2000];
    make_soup(triangles, 2000, 0.2f, 17);
    for (int i = 0; i < 2000; i++)
        for (int j = 0; j < 3; j++) {
            triangles[i].v[j][1] -= 0.5f;
            triangles[i].v[j][2] = ldexpf(triangles[i].v[j][2], -70);
        }
    triangles[0].v[0][2] = 1;
    triangles[1].v[0][2] = -1;
    struct mlrt_tree tree = build_with(triangles, 2000, NULL);
    assert_true(tree.kdtree.float_safe);
    free_tree(&tree);
}

static void test_a_scene_out_of_range_is_not_safe(void **state)
{
    (void)state;
    struct mlrt_triangle triangle = {{{0, 0, 5}, {0x1p61f, 0, 5}, {0, 1, 5}}};
    struct mlrt_tree tree = build_with(&triangle, 1, NULL);
    assert_false(tree.kdtree.float_safe);
    free_tree(&tree);
}

/* ---- options ------------------------------------------------------------------------------------------------- */

static void test_the_same_input_gives_the_same_tree(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[5000];
    make_soup(triangles, 5000, 0.1f, 18);
    struct mlrt_tree first = build_with(triangles, 5000, NULL), second = build_with(triangles, 5000, NULL);
    assert_true(first.info.tree_hash == second.info.tree_hash);
    assert_memory_equal(first.kdtree.nodes, second.kdtree.nodes, first.kdtree.node_count * sizeof *first.kdtree.nodes);
    triangles[77].v[0][0] += 0.5f;
    struct mlrt_tree other = build_with(triangles, 5000, NULL);
    assert_true(other.info.tree_hash != first.info.tree_hash);
    free_tree(&first);
    free_tree(&second);
    free_tree(&other);
}

static void test_the_depth_limit_holds(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[5000];
    make_soup(triangles, 5000, 0.1f, 19);
    static const uint32_t limits[] = {1, 2, 7, 60};
    for (int i = 0; i < 4; i++) {
        mlrt_kdtree_options options = tuned_options();
        options.max_depth = limits[i];
        struct mlrt_tree tree = build_with(triangles, 5000, &options);
        assert_true(tree.info.depth <= limits[i] && tree.info.depth > 0);
        free_tree(&tree);
    }
}

static void test_the_reference_limit_holds(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[5000];
    make_soup(triangles, 5000, 0.3f, 20);
    static const uint64_t limits[] = {5000, 5001, 7000, 20000};
    for (int i = 0; i < 4; i++) {
        mlrt_kdtree_options options = tuned_options();
        options.preset = MLRT_KDTREE_PAPER;
        options.rules_off = MLRT_RULE_RETRACTION;
        options.max_references = limits[i];
        struct mlrt_tree tree = build_with(triangles, 5000, &options);
        assert_true(tree.info.reference_count <= limits[i]);
        assert_true(tree.info.leaf_count > 1 || limits[i] < 7000);
        free_tree(&tree);
    }
}

static void test_each_rule_can_be_off(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[6000];
    uint32_t count = make_rooms(triangles, 6, 21);
    make_soup(triangles + count, 1000, 0.5f, 22);
    for (uint32_t rules_off = 0; rules_off < 32; rules_off++) {
        mlrt_kdtree_options options = tuned_options();
        options.rules_off = rules_off;
        struct mlrt_tree tree = build_with(triangles, count + 1000, &options);
        assert_true(tree.info.reference_count <= entry_limit(count + 1000));
        if (rules_off & MLRT_RULE_RETRACTION) assert_int_equal(tree.info.retracted_count, 0);
        free_tree(&tree);
    }
}

static void test_clipped_splits_save_references(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[2000];
    make_soup(triangles, 2000, 0.5f, 23);
    mlrt_kdtree_options options = tuned_options();
    struct mlrt_tree clipped = build_with(triangles, 2000, &options);
    options.rules_off = MLRT_RULE_CLIPPED_SPLITS;
    struct mlrt_tree boxes = build_with(triangles, 2000, &options);
    assert_true(clipped.info.sah_cost < boxes.info.sah_cost);
    free_tree(&clipped);
    free_tree(&boxes);
}

static void test_retraction_never_costs(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[2000];
    make_soup(triangles, 2000, 0.5f, 24);
    mlrt_kdtree_options options = tuned_options();
    struct mlrt_tree retracted = build_with(triangles, 2000, &options);
    options.rules_off = MLRT_RULE_RETRACTION;
    struct mlrt_tree kept = build_with(triangles, 2000, &options);
    assert_true(retracted.info.retracted_count > 0);
    assert_true(retracted.info.sah_cost <= kept.info.sah_cost);
    free_tree(&retracted);
    free_tree(&kept);
}

static void test_more_costly_tests_make_smaller_leaves(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[2000];
    make_soup(triangles, 2000, 0.05f, 25);
    mlrt_kdtree_options options = tuned_options();
    options.intersection_cost = 0.2f;
    struct mlrt_tree fat = build_with(triangles, 2000, &options);
    options.intersection_cost = 5;
    struct mlrt_tree lean = build_with(triangles, 2000, &options);
    assert_true(fat.info.node_count < lean.info.node_count);
    free_tree(&fat);
    free_tree(&lean);
}

/* More references than the threshold for bins. */
static void test_a_large_scene(void **state)
{
    (void)state;
    uint32_t count = 60000;
    struct mlrt_triangle *triangles = malloc(count * sizeof *triangles);
    make_soup(triangles, count, 0.02f, 26);
    struct mlrt_tree tree = build_with(triangles, count, NULL);
    assert_true(tree.info.leaf_count > 10000);
    free_tree(&tree);
    free(triangles);
}

/* ---- threads ------------------------------------------------------------------------------------------------- */

/* A saved kd-tree of a scene. The caller frees *data. */
static size_t save_kdtree(const mlrt_mesh *mesh, const mlrt_kdtree_options *options, unsigned char **data)
{
    mlrt_tree *tree;
    size_t size, written;
    assert_int_equal(mlrt_build_kdtree(mesh, 1, options, &tree), MLRT_OK);
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, &size), MLRT_OK);
    *data = allocate_or_fail(size, 1);
    assert_int_equal(mlrt_save_tree(tree, *data, size, &written), MLRT_OK);
    mlrt_destroy_tree(tree);
    return size;
}

/* Scenes of several parts. With steps so costly, subtrees above the parts are turned back into leaves. */
static void test_threads_change_nothing(void **state)
{
    (void)state;
    static const char *const names[] = {"room", "doubled", "scan:20000"};
    static const uint32_t thread_counts[] = {1, 3, 8};
    static const mlrt_kdtree_options builds[] = {
        {.preset = MLRT_KDTREE_PAPER}, {.preset = MLRT_KDTREE_TUNED}, {.rules_off = 31},
        {.traversal_cost = 1000},      {.max_references = 60000},     {.max_depth = 4},
    };
    for (size_t s = 0; s < (SANITIZED ? 1 : sizeof names / sizeof *names); s++) {
        struct scene scene;
        assert_int_equal(load_scene(names[s], &scene), 0);
        const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                                .vertices = scene.vertices,
                                .vertex_count = scene.vertex_count,
                                .indices = scene.indices,
                                .triangle_count = scene.triangle_count};
        for (size_t b = first_variant(); b < sizeof builds / sizeof *builds; b += variant_step()) {
            mlrt_kdtree_options options = builds[b];
            unsigned char *alone, *data;
            options.struct_size = sizeof options;
            const size_t size = save_kdtree(&mesh, &options, &alone);
            for (size_t i = 0; i < sizeof thread_counts / sizeof *thread_counts; i++) {
                options.pool = shared_pool(thread_counts[i]);
                assert_int_equal(save_kdtree(&mesh, &options, &data), size);
                assert_memory_equal(data, alone, size);
                free(data);
            }
            free(alone);
        }
        free_scene(&scene);
    }
}

/* ---- memory -------------------------------------------------------------------------------------------------- */

static void run_out_of_memory(struct mlrt_triangle *triangles, uint32_t count, mlrt_pool *pool)
{
    const mlrt_kdtree_options options = {.struct_size = sizeof options, .pool = pool};
    int32_t status = MLRT_ERROR_OUT_OF_MEMORY;
    uint32_t failure_count = 0;
    for (uint64_t limit = 1; status != MLRT_OK; limit += limit / (SANITIZED ? 8 : 16) + 1) {
        struct mlrt_tree tree;
        memset(&tree, 0, sizeof tree);
        tree.memory.limit_size = limit;
        tree.triangles = triangles;
        mlrt_find_triangles(&tree);
        tree.triangle_count = count;
        status = mlrt_build_nodes(&tree, &options, NULL);
        if (status == MLRT_OK) {
            free_tree(&tree);
            continue;
        }
        failure_count++;
        assert_int_equal(status, MLRT_ERROR_OUT_OF_MEMORY);
        assert_null(tree.kdtree.nodes);
        assert_null(tree.kdtree.references);
        assert_int_equal(tree.memory.held_size, 0);
    }
    assert_true(failure_count > 50);
}

static void test_running_out_of_memory_anywhere_leaves_nothing(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[12000];
    const uint32_t count = make_rooms(triangles, 4, 27);
    make_soup(triangles + count, 300, 2, 28);
    run_out_of_memory(triangles, count + 300, NULL);
    make_soup(triangles, 12000, 0.05f, 30);
    run_out_of_memory(triangles, 12000, NULL);
    run_out_of_memory(triangles, 12000, shared_pool(3));
}

static void test_the_peak_is_reported(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[2000];
    make_soup(triangles, 2000, 0.1f, 29);
    struct mlrt_tree tree = build_with(triangles, 2000, NULL);
    assert_true(tree.memory.peak_size >= 8 * tree.info.node_count + 4 * tree.info.reference_count);
    free_tree(&tree);
}

/* ---- the check itself ---------------------------------------------------------------------------------------- */

static void test_the_check_sees_what_is_broken(void **state)
{
    (void)state;
    static struct mlrt_triangle triangles[200];
    make_soup(triangles, 200, 0.1f, 30);
    struct mlrt_tree tree = build_with(triangles, 200, NULL);
    struct mlrt_node root = tree.kdtree.nodes[0];
    tree.kdtree.nodes[0].u.split = 100;
    assert_non_null(check_kdtree(&tree));
    tree.kdtree.nodes[0].u.split = 0.5f * (root.u.split + tree.bounds.lo[mlrt_node_axis(&root)]);
    assert_non_null(check_kdtree(&tree));
    tree.kdtree.nodes[0] = root;
    tree.kdtree.nodes[0].word += 4;
    assert_non_null(check_kdtree(&tree));
    tree.kdtree.nodes[0] = root;
    uint32_t entry = tree.kdtree.references[tree.kdtree.reference_count - 1];
    tree.kdtree.references[tree.kdtree.reference_count - 1] = 200;
    assert_non_null(check_kdtree(&tree));
    tree.kdtree.references[tree.kdtree.reference_count - 1] = entry;
    assert_null(check_kdtree(&tree));
    free_tree(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_triangles_make_one_empty_leaf),
        cmocka_unit_test(test_one_triangle),
        cmocka_unit_test(test_triangles_that_cannot_be_hit_are_counted_and_left_out),
        cmocka_unit_test(test_minus_zero_is_zero),
        cmocka_unit_test(test_identical_triangles),
        cmocka_unit_test(test_a_fan_through_one_point),
        cmocka_unit_test(test_one_huge_triangle_over_many_small_ones),
        cmocka_unit_test(test_a_scene_flat_in_one_axis),
        cmocka_unit_test(test_walls_on_the_faces_of_cells),
        cmocka_unit_test(test_a_room_has_flat_cells_and_an_empty_inside),
        cmocka_unit_test(test_extents_of_one_float),
        cmocka_unit_test(test_mixed_scales),
        cmocka_unit_test(test_the_largest_and_the_smallest_floats),
        cmocka_unit_test(test_a_safe_scene_makes_a_safe_tree),
        cmocka_unit_test(test_a_scene_out_of_range_is_not_safe),
        cmocka_unit_test(test_the_same_input_gives_the_same_tree),
        cmocka_unit_test(test_the_depth_limit_holds),
        cmocka_unit_test(test_the_reference_limit_holds),
        cmocka_unit_test(test_each_rule_can_be_off),
        cmocka_unit_test(test_clipped_splits_save_references),
        cmocka_unit_test(test_retraction_never_costs),
        cmocka_unit_test(test_more_costly_tests_make_smaller_leaves),
        cmocka_unit_test(test_a_large_scene),
        cmocka_unit_test(test_threads_change_nothing),
        cmocka_unit_test(test_running_out_of_memory_anywhere_leaves_nothing),
        cmocka_unit_test(test_the_peak_is_reported),
        cmocka_unit_test(test_the_check_sees_what_is_broken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
