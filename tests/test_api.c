/* SPDX-License-Identifier: MIT */
/*
 * The contract at the border: what is an error and which one, what is left behind after it, that nothing is printed,
 * and that the caller's floating-point environment neither matters nor changes.
 */
#define _GNU_SOURCE     1 /* feenableexcept, where there is one */
#define _POSIX_C_SOURCE 200809L

#include <fcntl.h>
#include <fenv.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support.h"

#if defined(__SSE2__)
#include <xmmintrin.h>
#define HAS_MXCSR 1
#else
#define HAS_MXCSR 0
#endif

static const float corners[18] = {0, 0, 5, 1, 0, 5, 0, 1, 5, 0, 0, 7, 1, 0, 7, 0, 1, 7};

static mlrt_mesh two_triangles(void)
{
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 6, .triangle_count = 2};
    return mesh;
}

static mlrt_tree *some_tree(void)
{
    mlrt_mesh mesh = two_triangles();
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    return tree;
}

/* Builds and expects an error; the tree must be NULL then. */
static void assert_build(const mlrt_mesh *meshes, size_t count, const mlrt_tree_options *options, int32_t expected)
{
    mlrt_tree *tree = (mlrt_tree *)(uintptr_t)16;
    assert_int_equal(mlrt_build_tree(meshes, count, options, &tree), expected);
    if (expected == MLRT_OK) {
        assert_non_null(tree);
        mlrt_destroy_tree(tree);
    } else {
        assert_null(tree);
    }
}

static void assert_mesh(const mlrt_mesh *mesh, int32_t expected)
{
    assert_build(mesh, 1, NULL, expected);
}

static void assert_options(const mlrt_tree_options *options, int32_t expected)
{
    mlrt_mesh mesh = two_triangles();
    assert_build(&mesh, 1, options, expected);
}

/* ---- versions and texts ------------------------------------------------------------------------------------------ */

static void version_is_that_of_the_header(void **state)
{
    (void)state;
    assert_int_equal(mlrt_version(), MLRT_VERSION_MAJOR * 10000 + MLRT_VERSION_MINOR * 100 + MLRT_VERSION_PATCH);
}

static void every_status_has_its_own_text(void **state)
{
    (void)state;
    for (int32_t a = MLRT_OK; a <= MLRT_ERROR_CANCELLED; a++) {
        assert_non_null(mlrt_status_string(a));
        assert_true(strlen(mlrt_status_string(a)) > 1);
        for (int32_t b = MLRT_OK; b < a; b++) assert_string_not_equal(mlrt_status_string(a), mlrt_status_string(b));
    }
}

static void unknown_statuses_have_a_text(void **state)
{
    (void)state;
    static const int32_t unknown[] = {-1, 10, 1000, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < sizeof unknown / sizeof unknown[0]; i++)
        assert_true(strlen(mlrt_status_string(unknown[i])) > 1);
}

/*
 * A field put into padding would not change sizeof. The sums are those of the fields on machines with 64-bit pointers.
 */
static void structs_have_no_padding(void **state)
{
    (void)state;
    if (sizeof(void *) != 8) skip();
    assert_int_equal(sizeof(mlrt_mesh), 4 * 4 + 6 * 8);
    assert_int_equal(sizeof(mlrt_host), 2 * 4 + 5 * 8);
    assert_int_equal(sizeof(mlrt_tree_options), 4 * 4 + 5 * 8);
    assert_int_equal(sizeof(mlrt_kdtree_options), 4 * 4 + 5 * 8 + 2 * 4 + 8);
    assert_int_equal(sizeof(mlrt_memory_estimate), 2 * 4 + 2 * 8);
    assert_int_equal(sizeof(mlrt_load_options), 2 * 4 + 5 * 8);
    assert_int_equal(sizeof(mlrt_pool_options), 2 * 4 + 4 * 8);
    assert_int_equal(sizeof(mlrt_tree_info), 2 * 4 + 11 * 8 + 2 * 8 + 8 * 4);
    assert_int_equal(sizeof(mlrt_counters), 2 * 4 + 19 * 8);
    assert_int_equal(sizeof(mlrt_trace_options), 14 * 4 + 4 * 8);
    assert_int_equal(sizeof(mlrt_hits), 2 * 4 + 7 * 24);
    assert_int_equal(sizeof(mlrt_rays), 2 * 4 + 8 + 6 * 16 + 2 * 4);
    assert_int_equal(sizeof(mlrt_ray), 12 * 4);
    assert_int_equal(sizeof(mlrt_hit), 8 * 4);
    assert_int_equal(sizeof(mlrt_hit_lists), 2 * 4 + 9 * 24);
    assert_int_equal(sizeof(mlrt_camera), 27 * 4);
    assert_int_equal(sizeof(mlrt_tile), 6 * 4 + 7 * 8);
    assert_int_equal(sizeof(mlrt_light), 5 * 4);
    assert_int_equal(sizeof(mlrt_points), 2 * 4 + 8 + 2 * 16);
}

/* ---- building ---------------------------------------------------------------------------------------------------- */

static void building_without_a_place_for_the_tree(void **state)
{
    (void)state;
    mlrt_mesh mesh = two_triangles();
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, NULL), MLRT_ERROR_ARGUMENT);
}

static void building_without_meshes(void **state)
{
    (void)state;
    assert_build(NULL, 0, NULL, MLRT_OK);
    assert_build(NULL, 1, NULL, MLRT_ERROR_ARGUMENT);
}

static void mesh_struct_sizes(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {0, 4, sizeof(mlrt_mesh) - 4, sizeof(mlrt_mesh) + 1024, 0xFFFFFFFFu};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        mlrt_mesh mesh = two_triangles();
        mesh.struct_size = sizes[i];
        assert_mesh(&mesh, MLRT_ERROR_STRUCT_SIZE);
    }
}

static void mesh_without_vertices(void **state)
{
    (void)state;
    mlrt_mesh mesh = two_triangles();
    mesh.vertices = NULL;
    assert_mesh(&mesh, MLRT_ERROR_ARGUMENT);
}

static void index_sizes(void **state)
{
    (void)state;
    static const uint16_t indices[6] = {0, 1, 2, 3, 4, 5};
    static const uint32_t wrong[] = {1, 3, 8, 0xFFFFFFFFu};
    mlrt_mesh mesh = two_triangles();
    mesh.indices = indices;
    mesh.index_size = 2;
    assert_mesh(&mesh, MLRT_OK);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        mesh.index_size = wrong[i];
        assert_mesh(&mesh, MLRT_ERROR_ARGUMENT);
    }
}

static void strides_that_are_not_multiples(void **state)
{
    (void)state;
    static const uint16_t indices[12] = {0, 1, 2, 3, 4, 5};
    mlrt_mesh mesh = two_triangles();
    mesh.vertex_stride = 13;
    assert_mesh(&mesh, MLRT_ERROR_ARGUMENT);
    mesh = two_triangles();
    mesh.indices = indices;
    mesh.index_size = 2;
    mesh.triangle_stride = 7;
    assert_mesh(&mesh, MLRT_ERROR_ARGUMENT);
}

/* 2^31 is the most, in bytes; a negative number as size_t is more. Of one element no other is read or written. */
#define GREATEST_STRIDE ((size_t)1 << 31)
static const size_t too_large[] = {GREATEST_STRIDE + 4, (size_t)0 - 12, (size_t)0 - 4};

static void strides_of_meshes_that_are_too_large(void **state)
{
    (void)state;
    static const uint32_t indices[6] = {0, 1, 2};
    mlrt_mesh good = two_triangles();
    good.indices = indices;
    good.triangle_count = 1;
    mlrt_mesh mesh = good;
    mesh.triangle_stride = GREATEST_STRIDE;
    assert_mesh(&mesh, MLRT_OK);
    for (size_t i = 0; i < sizeof too_large / sizeof too_large[0]; i++) {
        uint64_t hash = 0;
        mesh = good;
        mesh.triangle_stride = too_large[i];
        assert_mesh(&mesh, MLRT_ERROR_ARGUMENT);
        assert_int_equal(mlrt_hash_geometry(&mesh, 1, &hash), MLRT_ERROR_ARGUMENT);
        mesh = good;
        mesh.vertex_stride = too_large[i];
        assert_mesh(&mesh, MLRT_ERROR_ARGUMENT);
        assert_int_equal(mlrt_hash_geometry(&mesh, 1, &hash), MLRT_ERROR_ARGUMENT);
    }
    const uint32_t first_thrice[3] = {0, 0, 0};
    mesh = good;
    mesh.indices = first_thrice;
    mesh.vertex_stride = GREATEST_STRIDE;
    assert_mesh(&mesh, MLRT_OK);
}

static void triangles_without_enough_vertices(void **state)
{
    (void)state;
    mlrt_mesh mesh = two_triangles();
    mesh.vertex_count = 5;
    assert_mesh(&mesh, MLRT_ERROR_INDEX_RANGE);
    mesh.vertex_count = 0;
    assert_mesh(&mesh, MLRT_ERROR_INDEX_RANGE);
}

static void indices_out_of_range(void **state)
{
    (void)state;
    static const uint32_t wrong[] = {6, 7, 0x7FFFFFFFu, 0xFFFFFFFFu};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        for (int at = 0; at < 6; at++) {
            uint32_t indices[6] = {0, 1, 2, 3, 4, 5};
            indices[at] = wrong[i];
            mlrt_mesh mesh = two_triangles();
            mesh.indices = indices;
            assert_mesh(&mesh, MLRT_ERROR_INDEX_RANGE);
        }
    }
}

static void a_message_names_mesh_triangle_and_index(void **state)
{
    (void)state;
    const uint32_t good[3] = {0, 1, 2}, bad[6] = {0, 1, 2, 3, 98765, 5};
    char message[200] = "nothing";
    mlrt_mesh meshes[3] = {two_triangles(), two_triangles(), two_triangles()};
    meshes[1].indices = good;
    meshes[1].triangle_count = 1;
    meshes[2].indices = bad;
    mlrt_tree_options options = {.struct_size = sizeof options, .message = message, .message_size = sizeof message};
    assert_build(meshes, 3, &options, MLRT_ERROR_INDEX_RANGE);
    assert_non_null(strstr(message, "98765"));
    assert_non_null(strstr(message, "2"));
    assert_non_null(strstr(message, "1"));
    assert_non_null(strstr(message, "mesh"));
    assert_non_null(strstr(message, "triangle"));
}

static void messages_fit_their_buffer(void **state)
{
    (void)state;
    const uint32_t bad[6] = {0, 1, 2, 3, 98765, 5};
    for (size_t size = 0; size < 60; size++) {
        char message[64];
        memset(message, '#', sizeof message);
        mlrt_mesh mesh = two_triangles();
        mesh.indices = bad;
        mlrt_tree_options options = {.struct_size = sizeof options, .message = message, .message_size = size};
        assert_build(&mesh, 1, &options, MLRT_ERROR_INDEX_RANGE);
        for (size_t i = size; i < sizeof message; i++) assert_int_equal(message[i], '#');
        if (size > 0) assert_non_null(memchr(message, 0, size));
    }
}

static void ids_that_clash(void **state)
{
    (void)state;
    mlrt_mesh meshes[3] = {two_triangles(), two_triangles(), two_triangles()};
    assert_build(meshes, 3, NULL, MLRT_OK);
    meshes[0].id = 5;
    assert_build(meshes, 2, NULL, MLRT_OK);             // 5 and 0
    assert_build(meshes, 3, NULL, MLRT_ERROR_ARGUMENT); // 5, 0 and 0
    meshes[1].id = 5;
    assert_build(meshes, 2, NULL, MLRT_ERROR_ARGUMENT);
}

static void more_triangles_than_can_be_counted(void **state)
{
    (void)state;
    mlrt_mesh mesh = two_triangles();
    mesh.triangle_count = (size_t)1 << 31;
    mesh.vertex_count = (size_t)3 << 31;
    assert_mesh(&mesh, MLRT_ERROR_TOO_LARGE);
    mesh.triangle_count = SIZE_MAX;
    mesh.vertex_count = SIZE_MAX;
    assert_mesh(&mesh, MLRT_ERROR_TOO_LARGE);
    mlrt_mesh meshes[2] = {two_triangles(), two_triangles()};
    meshes[0].triangle_count = meshes[1].triangle_count = SIZE_MAX / 2 + 1; // the sum is 0
    meshes[0].vertex_count = meshes[1].vertex_count = SIZE_MAX;
    assert_build(meshes, 2, NULL, MLRT_ERROR_TOO_LARGE);
    meshes[0] = two_triangles();
    meshes[1].triangle_count = SIZE_MAX; // the sum is 1
    assert_build(meshes, 2, NULL, MLRT_ERROR_TOO_LARGE);
}

/* A size is that of a struct in some version: it does not end within a pointer. */
static void sizes_end_with_fields(void **state)
{
    (void)state;
    const mlrt_mesh mesh = two_triangles();
    const float zeros[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    uint32_t triangle;
    mlrt_rays rays = {.struct_size = offsetof(mlrt_rays, mask) + sizeof(void *) / 2,
                      .count = 1,
                      .origins = {.data = zeros},
                      .directions = {.data = up}};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {.data = &triangle}};
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_ERROR_STRUCT_SIZE);
    mlrt_destroy_tree(tree);
}

static void build_option_ranges(void **state)
{
    (void)state;
    mlrt_tree_options good = {.struct_size = sizeof good};
    mlrt_tree_options options = good;
    assert_options(&options, MLRT_OK);
    options.struct_size = 0;
    assert_options(&options, MLRT_ERROR_STRUCT_SIZE);
    options = good;
    options.preset = MLRT_TREE_BEST;
    assert_options(&options, MLRT_OK);
    options.preset = MLRT_TREE_BEST + 1;
    assert_options(&options, MLRT_ERROR_ARGUMENT);
    options.preset = -1;
    assert_options(&options, MLRT_ERROR_ARGUMENT);
}

static void assert_kdtree_options(const mlrt_kdtree_options *options, int32_t expected)
{
    const mlrt_mesh mesh = two_triangles();
    mlrt_tree *tree = (mlrt_tree *)(uintptr_t)16;
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    assert_int_equal(mlrt_build_kdtree(&mesh, 1, options, &tree), expected);
    assert_int_equal(tree != NULL, expected == MLRT_OK);
    assert_int_equal(mlrt_estimate_kdtree(&mesh, 1, options, &estimate), expected);
    mlrt_destroy_tree(tree);
}

static void kdtree_option_ranges(void **state)
{
    (void)state;
    static const float wrong[] = {-1, NAN, INFINITY, -INFINITY};
    const mlrt_kdtree_options good = {.struct_size = sizeof good};
    mlrt_kdtree_options options = {.struct_size = 0};
    assert_kdtree_options(NULL, MLRT_OK);
    assert_kdtree_options(&good, MLRT_OK);
    assert_kdtree_options(&options, MLRT_ERROR_STRUCT_SIZE);
    options = good;
    options.preset = MLRT_KDTREE_TUNED;
    assert_kdtree_options(&options, MLRT_OK);
    options.preset = MLRT_KDTREE_TUNED + 1;
    assert_kdtree_options(&options, MLRT_ERROR_ARGUMENT);
    options.preset = -1;
    assert_kdtree_options(&options, MLRT_ERROR_ARGUMENT);
    options = good;
    options.rules_off = 31;
    assert_kdtree_options(&options, MLRT_OK);
    options.rules_off = 32;
    assert_kdtree_options(&options, MLRT_ERROR_ARGUMENT);
    options = good;
    options.max_depth = 60;
    assert_kdtree_options(&options, MLRT_OK);
    options.max_depth = 61;
    assert_kdtree_options(&options, MLRT_ERROR_ARGUMENT);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        options = (mlrt_kdtree_options){.struct_size = sizeof options, .traversal_cost = wrong[i]};
        assert_kdtree_options(&options, MLRT_ERROR_ARGUMENT);
        options = (mlrt_kdtree_options){.struct_size = sizeof options, .intersection_cost = wrong[i]};
        assert_kdtree_options(&options, MLRT_ERROR_ARGUMENT);
    }
}

/* The message and the log name what is wrong. */
static void options_out_of_range_are_named(void **state)
{
    (void)state;
    static const char *const expected[] = {
        "options.preset: 2 is not from 0 to 1", "options.traversal_cost: -1 is not from 0 to 1e6",
        "options.intersection_cost: 2000000 is not from 0 to 1e6", "options.max_depth: 61 is not from 0 to 60",
        "options.rules_off: 32 is not from 0 to 31"};
    const mlrt_mesh mesh = two_triangles();
    for (int i = 0; i < 5; i++) {
        char message[64] = "stale", kdtree_message[64] = "stale";
        mlrt_tree *tree = (mlrt_tree *)(uintptr_t)16;
        const mlrt_kdtree_options kdtree = {.struct_size = sizeof kdtree,
                                            .preset = i == 0 ? 2 : 0,
                                            .traversal_cost = i == 1 ? -1 : 0,
                                            .intersection_cost = i == 2 ? 2e6f : 0,
                                            .max_depth = i == 3 ? 61 : 0,
                                            .rules_off = i == 4 ? 32 : 0,
                                            .message = kdtree_message,
                                            .message_size = sizeof kdtree_message};
        assert_int_equal(mlrt_build_kdtree(&mesh, 1, &kdtree, &tree), MLRT_ERROR_ARGUMENT);
        assert_null(tree);
        assert_string_equal(kdtree_message, expected[i]);
        if (i > 2) continue;
        const mlrt_tree_options boxes = {.struct_size = sizeof boxes,
                                         .preset = i == 0 ? 3 : 0,
                                         .traversal_cost = i == 1 ? -1 : 0,
                                         .intersection_cost = i == 2 ? 2e6f : 0,
                                         .message = message,
                                         .message_size = sizeof message};
        tree = (mlrt_tree *)(uintptr_t)16;
        assert_int_equal(mlrt_build_tree(&mesh, 1, &boxes, &tree), MLRT_ERROR_ARGUMENT);
        assert_null(tree);
        assert_string_equal(message, i == 0 ? "options.preset: 3 is not from 0 to 2" : expected[i]);
    }
}

/* Where headers say nothing, as in bindings written by hand: the other builder's options are of another size. */
static void options_of_the_other_builder_are_refused(void **state)
{
    (void)state;
    const mlrt_mesh mesh = two_triangles();
    mlrt_tree *tree = NULL;
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes, .preset = MLRT_TREE_FAST};
    const mlrt_kdtree_options depth = {.struct_size = sizeof depth, .max_depth = 3},
                              rules = {.struct_size = sizeof rules, .rules_off = 1};
    const void *others[] = {&depth, &rules};
    const void *other = &boxes;
    assert_int_equal(mlrt_build_kdtree(&mesh, 1, other, &tree), MLRT_ERROR_STRUCT_SIZE);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(mlrt_build_tree(&mesh, 1, others[i], &tree), MLRT_ERROR_STRUCT_SIZE);
        assert_null(tree);
    }
}

/* Without options: what each builder makes, and by which method it is traced. */
static void builders_make_what_they_are_named_for(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_icosphere(&soup, 3, 1);
    const mlrt_mesh mesh = soup_mesh(&soup);
    for (uint32_t structure = MLRT_STRUCTURE_KDTREE; structure <= MLRT_STRUCTURE_BVH; structure++) {
        const int is_kdtree = structure == MLRT_STRUCTURE_KDTREE;
        const mlrt_kdtree_options paper = {.struct_size = sizeof paper, .preset = MLRT_KDTREE_PAPER};
        const mlrt_tree_options best = {.struct_size = sizeof best, .preset = MLRT_TREE_DEFAULT};
        mlrt_tree *tree = NULL, *same = NULL;
        mlrt_tree_info info = {.struct_size = sizeof info}, same_info = info;
        assert_int_equal(is_kdtree ? mlrt_build_kdtree(&mesh, 1, NULL, &tree) : mlrt_build_tree(&mesh, 1, NULL, &tree),
                         MLRT_OK);
        assert_int_equal(
            is_kdtree ? mlrt_build_kdtree(&mesh, 1, &paper, &same) : mlrt_build_tree(&mesh, 1, &best, &same), MLRT_OK);
        assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
        assert_int_equal(mlrt_get_tree_info(same, &same_info), MLRT_OK);
        assert_int_equal(info.structure, structure);
        assert_int_equal(info.reserved, 0);
        assert_true(info.tree_hash == same_info.tree_hash);
        mlrt_destroy_tree(same);

        /* The default's counters are those of one method, and of no other. */
        const float eye[3] = {0.5f, -3, 1}, target[3] = {0, 0, 0};
        const mlrt_camera camera = look_at(eye, target, 1, 64, 64);
        uint32_t ids[64 * 64];
        const mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {ids, 0, 0}};
        mlrt_counters counted[MLRT_METHOD_TILE + 1];
        for (int32_t method = MLRT_METHOD_DEFAULT; method <= MLRT_METHOD_TILE; method++) {
            memset(&counted[method], 0, sizeof counted[method]);
            counted[method].struct_size = sizeof counted[method];
            const mlrt_trace_options options = {
                .struct_size = sizeof options, .method = method, .counters = &counted[method]};
            const int is_there = method < MLRT_METHOD_PACKET2 || (method == MLRT_METHOD_TILE) != is_kdtree;
            assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL),
                             is_there ? MLRT_OK : MLRT_ERROR_UNSUPPORTED);
        }
        const int32_t expected = is_kdtree ? MLRT_METHOD_MULTILEVEL : MLRT_METHOD_TILE;
        assert_int_equal(counted[MLRT_METHOD_DEFAULT].beam_count > 0, is_kdtree);
        for (int32_t method = MLRT_METHOD_RAY; method <= MLRT_METHOD_TILE; method++) {
            assert_int_equal(memcmp(&counted[MLRT_METHOD_DEFAULT], &counted[method], sizeof *counted) == 0,
                             method == expected);
        }
        mlrt_destroy_tree(tree);
    }
    free_soup(&soup);
}

static void build_costs_must_be_finite_and_not_negative(void **state)
{
    (void)state;
    static const float wrong[] = {-1, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        mlrt_tree_options options = {.struct_size = sizeof options, .traversal_cost = wrong[i]};
        assert_options(&options, MLRT_ERROR_ARGUMENT);
        options.traversal_cost = 0;
        options.intersection_cost = wrong[i];
        assert_options(&options, MLRT_ERROR_ARGUMENT);
    }
}

static void max_references_bounds_the_tree(void **state)
{
    (void)state;
    struct random random = {1};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 500, 1, 1);
    mlrt_mesh mesh = soup_mesh(&soup);
    for (uint64_t limit = 500; limit <= 4000; limit *= 2) {
        mlrt_kdtree_options options = {.struct_size = sizeof options, .max_references = limit};
        mlrt_tree *tree = NULL;
        mlrt_tree_info info = {.struct_size = sizeof info};
        assert_int_equal(mlrt_build_kdtree(&mesh, 1, &options, &tree), MLRT_OK);
        assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
        assert_true(info.reference_count <= limit);
        mlrt_destroy_tree(tree);
    }
    free_soup(&soup);
}

/* ---- the build report -------------------------------------------------------------------------------------------- */

static mlrt_tree_info info_of(const mlrt_tree *tree)
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
    return info;
}

static void tree_info_counts_what_is_left_out(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {0, 1, 0}, line[3] = {2, 0, 0}, bad[3] = {0, NAN, 0},
                far[3] = {0, 0, -INFINITY};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    soup_add_triangle(&soup, a, b, line);
    soup_add_triangle(&soup, a, b, b);
    soup_add_triangle(&soup, a, b, bad);
    soup_add_triangle(&soup, far, far, far);
    soup_add_triangle(&soup, bad, bad, a);
    struct fixture fixture = fixture_of_soup("left out", 0, &soup);
    for (int i = 0; i < 2; i++) {
        mlrt_tree_info info = info_of(i ? fixture.kdtree : fixture.tree);
        assert_int_equal(info.triangle_count, 6);
        assert_int_equal(info.zero_area_count, reference_zero_area_count(fixture.reference));
        assert_int_equal(info.non_finite_count, reference_non_finite_count(fixture.reference));
    }
    free_fixture(&fixture);
}

static void zero_area_is_decided_exactly(void **state)
{
    (void)state;
    struct random random = {2};
    struct soup soup = {0};
    for (int i = 0; i < 400; i++) {
        float p[3][3];
        // Points on a line, exactly or nearly so.
        draw_point(&random, -1, 1, p[0]);
        float side[3] = {draw_range(&random, -1, 1), draw_range(&random, -1, 1), draw_range(&random, -1, 1)};
        for (int k = 0; k < 3; k++) {
            if (i % 2) p[0][k] = 0;
            p[1][k] = p[0][k] + side[k];
            p[2][k] = p[0][k] + 2 * side[k];
        }
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("nearly collinear", 2, &soup);
    assert_int_equal(info_of(fixture.tree).zero_area_count, reference_zero_area_count(fixture.reference));
    assert_in_range(reference_zero_area_count(fixture.reference), 200, 390);
    free_fixture(&fixture);
}

static void tree_info_bounds_are_those_of_usable_triangles(void **state)
{
    (void)state;
    const float a[3] = {-1, 2, 3}, b[3] = {4, -5, 3}, c[3] = {0, 1, 9}, bad[3] = {100, NAN, 0}, out[3] = {50, 50, 50};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    soup_add_triangle(&soup, a, b, bad);
    soup_add_triangle(&soup, out, out, a);
    struct fixture fixture = fixture_of_soup("bounds", 0, &soup);
    mlrt_tree_info info = info_of(fixture.tree);
    const float lo[3] = {-1, -5, 3}, hi[3] = {4, 2, 9};
    assert_memory_equal(info.bounds_min, lo, sizeof lo);
    assert_memory_equal(info.bounds_max, hi, sizeof hi);
    free_fixture(&fixture);
}

static void tree_info_of_an_empty_tree(void **state)
{
    (void)state;
    const float zero[3] = {0, 0, 0};
    struct fixture fixture = make_fixture("empty", 0, NULL, 0);
    mlrt_tree_info info = info_of(fixture.tree);
    assert_int_equal(info.triangle_count, 0);
    assert_int_equal(info.reference_count, 0);
    assert_int_equal(info.depth, 0);
    assert_memory_equal(info.bounds_min, zero, sizeof zero);
    assert_memory_equal(info.bounds_max, zero, sizeof zero);
    free_fixture(&fixture);
}

static void tree_info_is_consistent(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_icosphere(&soup, 3, 1);
    struct fixture fixture = fixture_of_soup("sphere", 0, &soup);
    mlrt_tree_info info = info_of(fixture.kdtree);
    assert_int_equal(info.triangle_count, 1280);
    assert_int_equal(info.node_count, 2 * info.leaf_count - 1);
    assert_true(info.empty_leaf_count <= info.leaf_count);
    assert_true(info.reference_count >= 1280);
    assert_true(info.memory_size > 0 && info.peak_memory_size >= info.memory_size);
    assert_true(info.depth <= 60 && info.sah_cost > 0 && info.build_seconds >= 0);
    free_fixture(&fixture);
}

static void the_same_input_gives_the_same_tree(void **state)
{
    (void)state;
    struct random random = {3};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 700, 1, 0.2f);
    mlrt_mesh mesh = soup_mesh(&soup);
    uint64_t hash[2];
    for (int i = 0; i < 2; i++) {
        mlrt_tree *tree = NULL;
        assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
        hash[i] = info_of(tree).tree_hash;
        mlrt_destroy_tree(tree);
    }
    assert_true(hash[0] == hash[1]);
    free_soup(&soup);
}

static void tree_info_errors(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_get_tree_info(NULL, &info), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_get_tree_info(tree, NULL), MLRT_ERROR_ARGUMENT);
    info.struct_size = 0;
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_ERROR_STRUCT_SIZE);
    info.struct_size = sizeof info + 1024;
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_ERROR_STRUCT_SIZE);
    mlrt_destroy_tree(tree);
}

/* ---- pools ------------------------------------------------------------------------------------------------------- */

static void pool_errors(void **state)
{
    (void)state;
    mlrt_pool *pool = (mlrt_pool *)(uintptr_t)16;
    assert_int_equal(mlrt_create_pool(1025, &pool), MLRT_ERROR_ARGUMENT);
    assert_null(pool);
    assert_int_equal(mlrt_create_pool(0xFFFFFFFFu, &pool), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_create_pool(2, NULL), MLRT_ERROR_ARGUMENT);
}

static void pools_know_their_threads(void **state)
{
    (void)state;
    assert_int_equal(mlrt_pool_thread_count(NULL), 1);
    for (uint32_t count = 0; count < 4; count++) {
        mlrt_pool *pool;
        assert_int_equal(mlrt_create_pool(count, &pool), MLRT_OK);
        assert_int_equal(mlrt_pool_thread_count(pool), count ? count : (uint32_t)sysconf(_SC_NPROCESSORS_ONLN));
        mlrt_destroy_pool(pool);
    }
}

static void destroying_null_does_nothing(void **state)
{
    (void)state;
    mlrt_destroy_tree(NULL);
    mlrt_destroy_pool(NULL);
}

/* ---- tracing ----------------------------------------------------------------------------------------------------- */

struct call {
    mlrt_tree *tree;
    float origin[3];
    float direction[3];
    float t;
    uint8_t occluded;
    mlrt_rays rays;
    mlrt_hits hits;
    mlrt_trace_options options;
};

static void make_call(struct call *call)
{
    memset(call, 0, sizeof *call);
    call->tree = some_tree();
    call->origin[0] = call->origin[1] = 0.25f;
    call->direction[2] = 1;
    call->rays = (mlrt_rays){
        .struct_size = sizeof call->rays, .count = 1, .origins = {call->origin, 0}, .directions = {call->direction, 0}};
    call->hits = (mlrt_hits){.struct_size = sizeof call->hits, .t = {&call->t, 0, 0}};
    call->options.struct_size = sizeof call->options;
}

static int32_t trace(struct call *call)
{
    return mlrt_trace_packet(call->tree, &call->rays, &call->options, &call->hits);
}

/* Calls with one thing changed, and destroys what make_call made. */
static void assert_call(struct call *call, int32_t expected)
{
    call->t = -7;
    assert_int_equal(trace(call), expected);
    if (expected != MLRT_OK) assert_true(call->t == -7);
    mlrt_destroy_tree(call->tree);
}

static void tracing_without_arguments(void **state)
{
    (void)state;
    struct call call;
    make_call(&call);
    assert_int_equal(mlrt_trace_packet(NULL, &call.rays, NULL, &call.hits), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_packet(call.tree, NULL, NULL, &call.hits), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_packet(call.tree, &call.rays, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_call(&call, MLRT_OK);
}

static void tracing_without_origins_or_directions(void **state)
{
    (void)state;
    struct call call;
    make_call(&call);
    call.rays.origins.data = NULL;
    assert_call(&call, MLRT_ERROR_ARGUMENT);
    make_call(&call);
    call.rays.directions.data = NULL;
    assert_call(&call, MLRT_ERROR_ARGUMENT);
}

static void tracing_no_rays_needs_no_arrays(void **state)
{
    (void)state;
    struct call call;
    make_call(&call);
    call.rays = (mlrt_rays){.struct_size = sizeof call.rays};
    assert_int_equal(trace(&call), MLRT_OK);
    mlrt_destroy_tree(call.tree);
}

static void tracing_with_wrong_struct_sizes(void **state)
{
    (void)state;
    static const int32_t wrong[] = {0, 4, 4096};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        struct call call;
        make_call(&call);
        call.rays.struct_size = (uint32_t)wrong[i];
        assert_call(&call, MLRT_ERROR_STRUCT_SIZE);
        make_call(&call);
        call.hits.struct_size = (uint32_t)wrong[i];
        assert_call(&call, MLRT_ERROR_STRUCT_SIZE);
        make_call(&call);
        call.options.struct_size = (uint32_t)wrong[i];
        assert_call(&call, MLRT_ERROR_STRUCT_SIZE);
    }
}

static void assert_trace_options(mlrt_trace_options options, int32_t expected);

static void reserved_fields_must_be_zero(void **state)
{
    (void)state;
    mlrt_counters counters = {.struct_size = sizeof counters, .reserved = 1};
    struct call call;
    make_call(&call);
    call.hits.reserved = 1;
    assert_call(&call, MLRT_ERROR_ARGUMENT);
    make_call(&call);
    call.options.counters = &counters;
    assert_call(&call, MLRT_ERROR_ARGUMENT);
    assert_trace_options((mlrt_trace_options){.reserved = 1}, MLRT_ERROR_ARGUMENT);
}

static void too_many_rays(void **state)
{
    (void)state;
    struct call call;
    make_call(&call);
    call.rays.count = (size_t)1 << 31;
    assert_call(&call, MLRT_ERROR_TOO_LARGE);
    make_call(&call);
    call.rays.count = SIZE_MAX;
    assert_call(&call, MLRT_ERROR_TOO_LARGE);
}

/* A row is no wider than what there is to put into it. */
static void rows_longer_than_the_list(void **state)
{
    (void)state;
    struct call call;
    make_call(&call);
    call.rays.row_length = 0xFFFFFFFFu;
    assert_call(&call, MLRT_OK);
    assert_true(call.t > 0);
}

/* One field of the options at a time, out of its range. */
static void assert_trace_options(mlrt_trace_options options, int32_t expected)
{
    struct call call;
    make_call(&call);
    options.struct_size = sizeof options;
    call.options = options;
    assert_call(&call, expected);
}

static void trace_codes_out_of_range(void **state)
{
    (void)state;
    for (int32_t wrong = -1; wrong <= 100; wrong += 101) {
        assert_trace_options((mlrt_trace_options){.query = wrong}, MLRT_ERROR_ARGUMENT);
        assert_trace_options((mlrt_trace_options){.method = wrong}, MLRT_ERROR_ARGUMENT);
        assert_trace_options((mlrt_trace_options){.isa = wrong}, MLRT_ERROR_ARGUMENT);
        assert_trace_options((mlrt_trace_options){.culling = wrong}, MLRT_ERROR_ARGUMENT);
    }
    assert_trace_options((mlrt_trace_options){.culling_check = 2}, MLRT_ERROR_ARGUMENT);
    assert_trace_options((mlrt_trace_options){.outputs = 64}, MLRT_ERROR_ARGUMENT);
}

static void tile_sizes_out_of_range(void **state)
{
    (void)state;
    static const uint32_t wrong[] = {1, 2, 3, 5, 12, 100, 2048, 0x80000000u};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_trace_options((mlrt_trace_options){.initial_tile_size = wrong[i]}, MLRT_ERROR_ARGUMENT);
        assert_trace_options((mlrt_trace_options){.minimum_tile_size = wrong[i]}, MLRT_ERROR_ARGUMENT);
    }
    assert_trace_options((mlrt_trace_options){.initial_tile_size = 8, .minimum_tile_size = 16}, MLRT_ERROR_ARGUMENT);
    assert_trace_options((mlrt_trace_options){.initial_tile_size = 1024, .minimum_tile_size = 1024}, MLRT_OK);
    assert_trace_options((mlrt_trace_options){.initial_tile_size = 4}, MLRT_OK); // the default minimum fits in
}

/* Leaves bytes of a value where the next function has its variables. */
static void fill_stack(int value)
{
    volatile unsigned char bytes[8192];
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = (unsigned char)value;
}

static void one_ray_may_have_the_tiles_of_a_list(void **state)
{
    (void)state;
    const float wall[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    const mlrt_ray ray = {.struct_size = sizeof ray, .direction = {0, 0, 1}};
    const mlrt_rays list = {
        .struct_size = sizeof list, .count = 1, .origins = {ray.origin, 0}, .directions = {ray.direction, 0}};
    for (uint32_t structure = MLRT_STRUCTURE_KDTREE; structure <= MLRT_STRUCTURE_BVH; structure++) {
        mlrt_tree *tree = build_structure(&mesh, 1, structure);
        for (uint32_t size = 4; size <= 1024; size *= 2) {
            uint32_t triangle;
            mlrt_hit hit = {.struct_size = sizeof hit};
            const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {&triangle, 0, 0}};
            const mlrt_trace_options options = {.struct_size = sizeof options, .minimum_tile_size = size};
            const int32_t expected = mlrt_trace_packet(tree, &list, &options, &hits);
            for (int value = 0; value < 256; value += 51) {
                fill_stack(value);
                assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), expected);
            }
        }
        mlrt_destroy_tree(tree);
    }
}

static void split_factors_out_of_range(void **state)
{
    (void)state;
    static const uint32_t wrong[] = {1, 2, 3, 5, 8, 15, 64};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_trace_options((mlrt_trace_options){.split_factor = wrong[i]}, MLRT_ERROR_ARGUMENT);
}

static void counters_of_a_wrong_size(void **state)
{
    (void)state;
    mlrt_counters counters = {.struct_size = 0};
    assert_trace_options((mlrt_trace_options){.counters = &counters}, MLRT_ERROR_STRUCT_SIZE);
}

static void outputs_that_the_query_does_not_write(void **state)
{
    (void)state;
    struct call call;
    make_call(&call);
    call.hits.occluded.data = &call.occluded;
    assert_call(&call, MLRT_ERROR_ARGUMENT);
    make_call(&call);
    call.options.query = MLRT_QUERY_ANY;
    assert_call(&call, MLRT_ERROR_ARGUMENT);
}

static void single_ray_errors(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    mlrt_trace_options options = {.struct_size = 1};
    assert_int_equal(mlrt_trace_ray(NULL, &ray, NULL, &hit), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_ray(tree, NULL, NULL, &hit), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_ERROR_STRUCT_SIZE);
    ray.struct_size = 0;
    assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_ERROR_STRUCT_SIZE);
    ray.struct_size = sizeof ray;
    hit.struct_size = 0;
    assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_ERROR_STRUCT_SIZE);
    hit.struct_size = sizeof hit;
    ray.flags = 2;
    assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static mlrt_camera good_camera(void)
{
    mlrt_camera camera = {.struct_size = sizeof camera,
                          .width = 4,
                          .height = 4,
                          .direction = {0, 0, 1},
                          .d00 = {0, 0, 1},
                          .dx = {0.1f, 0, 0},
                          .dy = {0, 0.1f, 0}};
    return camera;
}

static void assert_camera(const mlrt_camera *camera, int32_t expected)
{
    mlrt_tree *tree = some_tree();
    float t[16], origins[48], directions[48];
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
    mlrt_array out_origins = {origins, 0, 0}, out_directions = {directions, 0, 0};
    assert_int_equal(mlrt_render_tiles(tree, camera, NULL, &frame, NULL, NULL), expected);
    assert_int_equal(mlrt_camera_rays(camera, &out_origins, &out_directions), expected);
    mlrt_destroy_tree(tree);
}

static void a_camera_that_is_good(void **state)
{
    (void)state;
    mlrt_camera camera = good_camera();
    assert_camera(&camera, MLRT_OK);
    camera.projection = MLRT_PROJECTION_PARALLEL;
    assert_camera(&camera, MLRT_OK);
}

static void cameras_of_size_zero(void **state)
{
    (void)state;
    mlrt_camera camera = good_camera();
    camera.width = 0;
    assert_camera(&camera, MLRT_ERROR_CAMERA);
    camera = good_camera();
    camera.height = 0;
    assert_camera(&camera, MLRT_ERROR_CAMERA);
}

static void cameras_that_are_not_finite(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            mlrt_camera camera = good_camera();
            camera.eye[k] = bad[i];
            assert_camera(&camera, MLRT_ERROR_CAMERA);
            camera = good_camera();
            camera.d00[k] = bad[i];
            assert_camera(&camera, MLRT_ERROR_CAMERA);
            camera = good_camera();
            camera.dx[k] = bad[i];
            assert_camera(&camera, MLRT_ERROR_CAMERA);
            camera = good_camera();
            camera.dy[k] = bad[i];
            assert_camera(&camera, MLRT_ERROR_CAMERA);
            camera = good_camera();
            camera.projection = MLRT_PROJECTION_PARALLEL;
            camera.direction[k] = bad[i];
            assert_camera(&camera, MLRT_ERROR_CAMERA);
        }
    }
}

static void cameras_that_span_no_picture(void **state)
{
    (void)state;
    mlrt_camera camera = good_camera();
    memset(camera.dx, 0, sizeof camera.dx);
    assert_camera(&camera, MLRT_ERROR_CAMERA);
    camera = good_camera();
    memset(camera.dy, 0, sizeof camera.dy);
    assert_camera(&camera, MLRT_ERROR_CAMERA);
    camera = good_camera();
    for (int k = 0; k < 3; k++) camera.dy[k] = -2 * camera.dx[k];
    assert_camera(&camera, MLRT_ERROR_CAMERA);
}

static void cameras_with_a_wrong_size_or_projection(void **state)
{
    (void)state;
    mlrt_camera camera = good_camera();
    camera.struct_size = 0;
    assert_camera(&camera, MLRT_ERROR_STRUCT_SIZE);
    camera = good_camera();
    camera.projection = 2;
    assert_camera(&camera, MLRT_ERROR_ARGUMENT);
}

/* Whichever code: none of these may be rendered. */
static void crops_beyond_the_picture(void **state)
{
    (void)state;
    static const uint32_t crops[][4] = {{4, 0, 0, 0}, {0, 4, 0, 0}, {0, 0, 5, 1}, {2, 2, 3, 1}, {1, 0, 0xFFFFFFFFu, 1}};
    mlrt_tree *tree = some_tree();
    float t[64];
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
    for (size_t i = 0; i < sizeof crops / sizeof crops[0]; i++) {
        mlrt_camera camera = good_camera();
        camera.crop_x = crops[i][0];
        camera.crop_y = crops[i][1];
        camera.crop_width = crops[i][2];
        camera.crop_height = crops[i][3];
        assert_int_not_equal(mlrt_render_tiles(tree, &camera, NULL, &frame, NULL, NULL), MLRT_OK);
    }
    mlrt_destroy_tree(tree);
}

static int32_t end_render(void *user, const mlrt_tile *tile)
{
    (void)user;
    (void)tile;
    return 1;
}

static void pictures_that_are_too_large(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    mlrt_camera camera = good_camera();
    camera.width = camera.height = 1u << 23;
    assert_camera(&camera, MLRT_ERROR_TOO_LARGE);
    camera.crop_height = 256; // 2^31 pixels
    assert_camera(&camera, MLRT_ERROR_TOO_LARGE);
    camera.crop_height = 255;
    assert_int_equal(mlrt_render_tiles(tree, &camera, NULL, NULL, end_render, NULL), MLRT_ERROR_CANCELLED);
    mlrt_destroy_tree(tree);
}

static void meshes_that_are_too_large(void **state)
{
    (void)state;
    mlrt_mesh meshes[2] = {{.struct_size = sizeof *meshes}, {.struct_size = sizeof *meshes}};
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    for (size_t last = 0; last < 2; last++) { // triangles of the last mesh
        meshes[0].triangle_count = ((size_t)1 << 30) - 1 - last;
        meshes[1].triangle_count = last;
        assert_int_equal(mlrt_estimate_tree(meshes, 2, NULL, &estimate), MLRT_OK);
        assert_int_equal(mlrt_estimate_kdtree(meshes, 2, NULL, &estimate), MLRT_OK);
        meshes[1].triangle_count++;
        assert_int_equal(mlrt_estimate_tree(meshes, 2, NULL, &estimate), MLRT_ERROR_TOO_LARGE);
        assert_int_equal(mlrt_estimate_kdtree(meshes, 2, NULL, &estimate), MLRT_ERROR_TOO_LARGE);
    }
}

static void rendering_without_arguments(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    mlrt_camera camera = good_camera();
    float t[16];
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
    assert_int_equal(mlrt_render_tiles(NULL, &camera, NULL, &frame, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_render_tiles(tree, NULL, NULL, &frame, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_render_tiles(tree, &camera, NULL, NULL, NULL, NULL), MLRT_ERROR_ARGUMENT);
    frame.struct_size = 0;
    assert_int_equal(mlrt_render_tiles(tree, &camera, NULL, &frame, NULL, NULL), MLRT_ERROR_STRUCT_SIZE);
    mlrt_destroy_tree(tree);
}

/* ---- light ------------------------------------------------------------------------------------------------------- */

static void strides_of_rays_and_hits_that_are_too_large(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    const float origin[3] = {0.25f, 0.25f, 0}, direction[3] = {0, 0, 1}, t_min = 0, t_max = 9;
    const uint32_t skip[2] = {MLRT_NONE, MLRT_NONE}, mask = 1;
    for (int a = 0; a < 6; a++) { // of rays
        uint32_t id = 7;
        const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {&id, 0, 0}};
        const mlrt_hit_lists lists = {.struct_size = sizeof lists, .capacity = 1, .triangle = {&id, 0, 0}};
        mlrt_rays rays = {.struct_size = sizeof rays,
                          .count = 1,
                          .origins = {origin, 0},
                          .directions = {direction, 0},
                          .t_min = {&t_min, 0},
                          .t_max = {&t_max, 0},
                          .skip = {skip, 0},
                          .mask = {&mask, 0}};
        mlrt_const_array *const arrays[] = {&rays.origins, &rays.directions, &rays.t_min,
                                            &rays.t_max,   &rays.skip,       &rays.mask};
        for (size_t i = 0; i < sizeof too_large / sizeof too_large[0]; i++) {
            arrays[a]->stride = too_large[i];
            assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_ERROR_ARGUMENT);
            assert_int_equal(mlrt_trace_all_hits(tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
        }
        assert_int_equal(id, 7);
        arrays[a]->stride = GREATEST_STRIDE;
        assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_OK);
        assert_int_equal(id, 0);
    }
    const mlrt_rays rays = {
        .struct_size = sizeof rays, .count = 1, .origins = {origin, 0}, .directions = {direction, 0}};
    for (int a = 0; a < 7; a++) { // of hits, and of lists of them
        uint32_t words[9];
        memset(words, 0x5A, sizeof words);
        mlrt_hits hits = {.struct_size = sizeof hits};
        mlrt_array *const arrays[] = {&hits.t,        &hits.u,      &hits.v,       &hits.mesh,
                                      &hits.triangle, &hits.facing, &hits.occluded};
        const mlrt_trace_options options = {.struct_size = sizeof options,
                                            .query = a == 6 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST};
        arrays[a]->data = words;
        for (size_t i = 0; i < sizeof too_large / sizeof too_large[0]; i++) {
            arrays[a]->stride = too_large[i];
            assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_ERROR_ARGUMENT);
        }
        assert_int_equal(words[0], 0x5A5A5A5A);
        arrays[a]->stride = GREATEST_STRIDE;
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
    }
    for (int a = 0; a < 9; a++) {
        uint32_t word = 7;
        mlrt_hit_lists lists = {.struct_size = sizeof lists, .capacity = a < 7 ? 1 : 0};
        mlrt_array *const arrays[] = {&lists.t,        &lists.u,        &lists.v,
                                      &lists.mesh,     &lists.triangle, &lists.facing,
                                      &lists.crossing, &lists.total,    &lists.crossing_total};
        arrays[a]->data = &word;
        for (size_t i = 0; i < sizeof too_large / sizeof too_large[0]; i++) {
            arrays[a]->stride = too_large[i];
            assert_int_equal(mlrt_trace_all_hits(tree, &rays, NULL, &lists), MLRT_ERROR_ARGUMENT);
        }
        assert_int_equal(word, 7);
        arrays[a]->stride = GREATEST_STRIDE;
        assert_int_equal(mlrt_trace_all_hits(tree, &rays, NULL, &lists), MLRT_OK);
    }
    mlrt_destroy_tree(tree);
}

static void strides_of_pictures_and_points_that_are_too_large(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    mlrt_camera camera = good_camera();
    float vectors[3] = {7, 7, 7};
    uint32_t id = 7;
    uint8_t occluded = 7;
    camera.crop_width = camera.crop_height = 1;
    for (int has_rows = 0; has_rows < 2; has_rows++) {
        mlrt_array out = {vectors, 0, 0};
        mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {&id, 0, 0}};
        for (size_t i = 0; i < sizeof too_large / sizeof too_large[0]; i++) {
            *(has_rows ? &out.row_stride : &out.stride) = too_large[i];
            *(has_rows ? &hits.triangle.row_stride : &hits.triangle.stride) = too_large[i];
            assert_int_equal(mlrt_camera_rays(&camera, &out, NULL), MLRT_ERROR_ARGUMENT);
            assert_int_equal(mlrt_camera_rays(&camera, NULL, &out), MLRT_ERROR_ARGUMENT);
            assert_int_equal(mlrt_render_tiles(tree, &camera, NULL, &hits, NULL, NULL), MLRT_ERROR_ARGUMENT);
        }
        *(has_rows ? &out.row_stride : &out.stride) = GREATEST_STRIDE;
        *(has_rows ? &hits.triangle.row_stride : &hits.triangle.stride) = GREATEST_STRIDE;
        assert_true(has_rows || (vectors[0] == 7 && id == 7));
        assert_int_equal(mlrt_camera_rays(&camera, &out, NULL), MLRT_OK);
        assert_int_equal(mlrt_render_tiles(tree, &camera, NULL, &hits, NULL, NULL), MLRT_OK);
    }
    const float position[3] = {0, 0, 0};
    const uint32_t skip[2] = {MLRT_NONE, MLRT_NONE};
    const mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_DIRECTIONAL, .position = {0, 0, 1}};
    for (int a = 0; a < 3; a++) {
        mlrt_points points = {.struct_size = sizeof points, .count = 1, .positions = {position, 0}, .skip = {skip, 0}};
        mlrt_array out = {&occluded, 0, 0};
        size_t *const strides[] = {&points.positions.stride, &points.skip.stride, &out.stride};
        for (size_t i = 0; i < sizeof too_large / sizeof too_large[0]; i++) {
            *strides[a] = too_large[i];
            assert_int_equal(mlrt_occluded_points(tree, &points, &light, NULL, &out), MLRT_ERROR_ARGUMENT);
        }
        assert_true(a > 0 || occluded == 7);
        *strides[a] = GREATEST_STRIDE;
        assert_int_equal(mlrt_occluded_points(tree, &points, &light, NULL, &out), MLRT_OK);
    }
    mlrt_destroy_tree(tree);
}

static void occlusion_errors(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    const float position[3] = {0, 0, 0};
    uint8_t result = 9;
    mlrt_points points = {.struct_size = sizeof points, .count = 1, .positions = {position, 0}}, bad_points = points;
    mlrt_light light = {.struct_size = sizeof light}, bad_light = light;
    mlrt_array out = {&result, 0, 0}, none = {NULL, 0, 0};
    bad_points.struct_size = 0;
    assert_int_equal(mlrt_occluded_points(NULL, &points, &light, NULL, &out), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_occluded_points(tree, NULL, &light, NULL, &out), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_occluded_points(tree, &points, NULL, NULL, &out), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_occluded_points(tree, &points, &light, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_occluded_points(tree, &bad_points, &light, NULL, &out), MLRT_ERROR_STRUCT_SIZE);
    bad_light.struct_size = 0;
    assert_int_equal(mlrt_occluded_points(tree, &points, &bad_light, NULL, &out), MLRT_ERROR_STRUCT_SIZE);
    bad_light = light;
    bad_light.kind = 2;
    assert_int_equal(mlrt_occluded_points(tree, &points, &bad_light, NULL, &out), MLRT_ERROR_ARGUMENT);
    bad_points = points;
    bad_points.positions.data = NULL;
    assert_int_equal(mlrt_occluded_points(tree, &bad_points, &light, NULL, &out), MLRT_ERROR_ARGUMENT);
    bad_points = points;
    bad_points.count = (size_t)1 << 31;
    assert_int_equal(mlrt_occluded_points(tree, &bad_points, &light, NULL, &out), MLRT_ERROR_TOO_LARGE);
    (void)none;
    assert_int_equal(result, 9);
    mlrt_destroy_tree(tree);
}

/* The options of a render with lights, one thing changed. What is written is nothing after an error. */
static void assert_lights(const mlrt_light *lights, uint32_t count, mlrt_trace_options options, int32_t expected)
{
    mlrt_tree *tree = some_tree();
    const mlrt_camera camera = good_camera();
    uint8_t occluded[16];
    const mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {occluded, 0, 0}};
    memset(occluded, 0x5A, sizeof occluded);
    options.struct_size = sizeof options;
    options.lights = lights;
    options.light_count = count;
    assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), expected);
    for (int i = 0; i < 16; i++) assert_true(expected == MLRT_OK ? occluded[i] != 0x5A : occluded[i] == 0x5A);
    mlrt_destroy_tree(tree);
}

static const mlrt_trace_options no_options;

static void lights_of_a_picture(void **state)
{
    (void)state;
    mlrt_light lights[9];
    for (int i = 0; i < 9; i++) lights[i] = (mlrt_light){.struct_size = sizeof lights[i], .position = {1, 2, 3}};
    assert_lights(lights, 1, no_options, MLRT_OK);
    assert_lights(lights, 8, no_options, MLRT_OK);
    assert_lights(lights, 9, no_options, MLRT_ERROR_ARGUMENT);
    assert_lights(lights, 0xFFFFFFFFu, no_options, MLRT_ERROR_ARGUMENT);
    assert_lights(NULL, 1, no_options, MLRT_ERROR_ARGUMENT);
    assert_lights(lights, 2, (mlrt_trace_options){.reserved = 1}, MLRT_ERROR_ARGUMENT);
    assert_lights(lights, 2, (mlrt_trace_options){.query = MLRT_QUERY_ANY}, MLRT_ERROR_ARGUMENT);
}

static void pictures_without_lights_have_no_shadows(void **state)
{
    (void)state;
    const mlrt_light light = {.struct_size = sizeof light};
    assert_lights(NULL, 0, no_options, MLRT_ERROR_ARGUMENT);
    assert_lights(&light, 0, no_options, MLRT_ERROR_ARGUMENT);
    assert_lights(NULL, 0, (mlrt_trace_options){.query = MLRT_QUERY_ANY}, MLRT_OK);
}

static void lights_that_are_wrong(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int at = 0; at < 3; at++) {
        mlrt_light lights[3];
        for (int i = 0; i < 3; i++) lights[i] = (mlrt_light){.struct_size = sizeof lights[i], .position = {1, 2, 3}};
        for (int k = 0; k < 3; k++) {
            lights[at].position[k] = bad[k];
            assert_lights(lights, 3, no_options, MLRT_ERROR_ARGUMENT);
            assert_lights(lights, (uint32_t)at, no_options, at ? MLRT_OK : MLRT_ERROR_ARGUMENT); // it is not looked at
            lights[at].position[k] = 1;
        }
        lights[at].kind = 2;
        assert_lights(lights, 3, no_options, MLRT_ERROR_ARGUMENT);
        lights[at].kind = -1;
        assert_lights(lights, 3, no_options, MLRT_ERROR_ARGUMENT);
        lights[at].kind = MLRT_LIGHT_DIRECTIONAL;
        assert_lights(lights, 3, no_options, MLRT_OK);
        lights[at].struct_size = 0;
        assert_lights(lights, 3, no_options, MLRT_ERROR_STRUCT_SIZE);
        lights[at].struct_size = sizeof lights[at] + 1;
        assert_lights(lights, 3, no_options, MLRT_ERROR_STRUCT_SIZE);
    }
}

/* In an array of structs all have the struct_size of the first: what is behind an array that says so is nobody's. */
static void lights_of_different_sizes(void **state)
{
    (void)state;
    mlrt_light *lights = allocate_guarded(2 * sizeof *lights);
    for (int i = 0; i < 2; i++) lights[i] = (mlrt_light){.struct_size = sizeof lights[i], .position = {1, 2, 3}};
    lights[1].struct_size = sizeof lights[1] - 4;
    assert_lights(lights, 2, no_options, MLRT_ERROR_STRUCT_SIZE);
    lights[1].struct_size = sizeof lights[1] + 4;
    assert_lights(lights, 2, no_options, MLRT_ERROR_STRUCT_SIZE);
    lights[1].struct_size = sizeof lights[1];
    assert_lights(lights, 2, no_options, MLRT_OK);
    free_guarded(lights, 2 * sizeof *lights);
}

/* Elsewhere there are no lights, not even none of them. */
static void lights_where_there_are_none(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    const mlrt_light light = {.struct_size = sizeof light, .position = {1, 2, 3}};
    const float position[3] = {0, 0, 0}, direction[3] = {0, 0, 1};
    uint8_t result = 9;
    uint32_t total = 9;
    float t = 9;
    const mlrt_array occluded = {&result, 0, 0};
    const mlrt_points points = {.struct_size = sizeof points, .count = 1, .positions = {position, 0}};
    const mlrt_rays rays = {
        .struct_size = sizeof rays, .count = 1, .origins = {position, 0}, .directions = {direction, 0}};
    const mlrt_hits hits = {.struct_size = sizeof hits, .t = {&t, 0, 0}};
    const mlrt_hit_lists lists = {.struct_size = sizeof lists, .total = {&total, 0, 0}};
    const mlrt_ray ray = {.struct_size = sizeof ray, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit, .t = 9};
    for (int i = 0; i < 3; i++) {
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .lights = i != 1 ? &light : NULL, .light_count = i != 0};
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_ERROR_ARGUMENT);
        assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_ERROR_ARGUMENT);
        assert_int_equal(mlrt_trace_all_hits(tree, &rays, &options, &lists), MLRT_ERROR_ARGUMENT);
        assert_int_equal(mlrt_occluded_points(tree, &points, &light, &options, &occluded), MLRT_ERROR_ARGUMENT);
    }
    assert_true(result == 9 && total == 9 && t == 9 && hit.t == 9);
    mlrt_destroy_tree(tree);
}

struct shadow_call {
    mlrt_ray ray;
    mlrt_hit hit;
    mlrt_light light;
};

static struct shadow_call good_shadow_call(void)
{
    return (struct shadow_call){
        .ray = {.struct_size = sizeof(mlrt_ray), .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}},
        .hit = {.struct_size = sizeof(mlrt_hit)},
        .light = {.struct_size = sizeof(mlrt_light), .position = {1, 2, 0}}};
}

/* After an error nothing is written. */
static void assert_shadow_call(const mlrt_tree *tree, const struct shadow_call *call, int32_t expected)
{
    mlrt_ray shadow = {.struct_size = sizeof shadow, .flags = 77};
    const mlrt_ray before = shadow;
    int32_t faces = 77;
    assert_int_equal(mlrt_shadow_ray(tree, &call->ray, &call->hit, &call->light, &shadow, &faces), expected);
    if (expected == MLRT_OK) return;
    assert_memory_equal(&shadow, &before, sizeof shadow);
    assert_int_equal(faces, 77);
}

static void shadow_rays_without_arguments(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    const struct shadow_call call = good_shadow_call();
    mlrt_ray shadow = {.struct_size = sizeof shadow};
    int32_t faces;
    const mlrt_ray *ray = &call.ray;
    const mlrt_hit *hit = &call.hit;
    const mlrt_light *light = &call.light;
    assert_int_equal(mlrt_shadow_ray(NULL, ray, hit, light, &shadow, &faces), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_shadow_ray(tree, NULL, hit, light, &shadow, &faces), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_shadow_ray(tree, ray, NULL, light, &shadow, &faces), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_shadow_ray(tree, ray, hit, NULL, &shadow, &faces), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_shadow_ray(tree, ray, hit, light, NULL, &faces), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_shadow_ray(tree, ray, hit, light, &shadow, NULL), MLRT_ERROR_ARGUMENT);
    assert_shadow_call(tree, &call, MLRT_OK);
    mlrt_destroy_tree(tree);
}

static void shadow_rays_with_wrong_struct_sizes(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    static const uint32_t wrong[] = {0, 4, 4096};
    for (size_t i = 0; i < 3; i++) {
        struct shadow_call call = good_shadow_call();
        call.ray.struct_size = wrong[i];
        assert_shadow_call(tree, &call, MLRT_ERROR_STRUCT_SIZE);
        call = good_shadow_call();
        call.hit.struct_size = wrong[i];
        assert_shadow_call(tree, &call, MLRT_ERROR_STRUCT_SIZE);
        call = good_shadow_call();
        call.light.struct_size = wrong[i];
        assert_shadow_call(tree, &call, MLRT_ERROR_STRUCT_SIZE);
        call = good_shadow_call();
        mlrt_ray shadow = {.struct_size = wrong[i]};
        int32_t faces;
        assert_int_equal(mlrt_shadow_ray(tree, &call.ray, &call.hit, &call.light, &shadow, &faces),
                         MLRT_ERROR_STRUCT_SIZE);
    }
    mlrt_destroy_tree(tree);
}

static void shadow_rays_of_wrong_lights_and_rays(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    struct shadow_call call = good_shadow_call();
    call.light.kind = 2;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.light.position[1] = NAN;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.ray.flags = 2;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.ray.origin[0] = NAN;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.ray.direction[2] = INFINITY;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.ray.direction[2] = 0;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

static void shadow_rays_of_misses(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    struct shadow_call call = good_shadow_call();
    call.ray.origin[0] = 2;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.ray.direction[2] = -1; // the triangle is behind it
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call = good_shadow_call();
    call.ray.t_min = 5; // the interval is half open
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call.ray.t_min = 0;
    call.ray.t_max = 5;
    assert_shadow_call(tree, &call, MLRT_OK);
    call.ray.t_max = 4.9f;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    call.ray.t_max = -INFINITY;
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

/* Who asks about a triangle behind the first one, or one that the ray skips, has a reason. */
static void shadow_rays_of_any_hit(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    struct shadow_call call = good_shadow_call();
    call.hit.triangle = 1;
    assert_shadow_call(tree, &call, MLRT_OK);
    call.ray.flags = MLRT_RAY_SKIP;
    call.ray.skip_triangle = 1;
    assert_shadow_call(tree, &call, MLRT_OK);
    mlrt_destroy_tree(tree);
}

static void shadow_rays_of_triangles_that_do_not_exist(void **state)
{
    (void)state;
    static const uint32_t wrong[][2] = {{1, 0}, {0, 2}, {MLRT_NONE, MLRT_NONE}, {0, MLRT_NONE}, {MLRT_NONE, 0}};
    mlrt_tree *tree = some_tree();
    for (size_t i = 0; i < 5; i++) {
        struct shadow_call call = good_shadow_call();
        call.hit.mesh = wrong[i][0];
        call.hit.triangle = wrong[i][1];
        assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    }
    mlrt_destroy_tree(tree);
    assert_int_equal(mlrt_build_tree(NULL, 0, NULL, &tree), MLRT_OK);
    const struct shadow_call call = good_shadow_call();
    assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

/* They are never hit: without an area, or with a corner that is not finite. */
static void shadow_rays_of_triangles_that_were_left_out(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        float left_out[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
        if (i < 3) {
            left_out[i] = bad[i];
        } else {
            memcpy(left_out + 6, left_out, 12);
        }
        const mlrt_mesh mesh = {
            .struct_size = sizeof mesh, .vertices = left_out, .vertex_count = 3, .triangle_count = 1};
        mlrt_tree *tree;
        assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
        for (int kind = 0; kind < 2; kind++) {
            struct shadow_call call = good_shadow_call();
            call.light.kind = kind;
            assert_shadow_call(tree, &call, MLRT_ERROR_ARGUMENT);
        }
        mlrt_destroy_tree(tree);
    }
}

static void offset_errors(void **state)
{
    (void)state;
    mlrt_tree *tree = some_tree();
    float point[3];
    assert_int_equal(mlrt_offset_point(NULL, 0, 0, 0.25f, 0.25f, 1, point), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, 0, 0, 0.25f, 0.25f, 1, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, 0, 0, 0.25f, 0.25f, 0, point), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, 0, 0, 0.25f, 0.25f, 2, point), MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

/* ---- silence ----------------------------------------------------------------------------------------------------- */

static void nothing_is_printed(void **state)
{
    (void)state;
    FILE *file = tmpfile();
    assert_non_null(file);
    fflush(NULL);
    int out = dup(1), err = dup(2);
    dup2(fileno(file), 1);
    dup2(fileno(file), 2);
    mlrt_tree *tree = NULL;
    mlrt_mesh mesh = two_triangles();
    float nan_ray[3] = {NAN, 0, 0}, t;
    mlrt_rays rays = {.struct_size = sizeof rays, .count = 1, .origins = {nan_ray, 0}, .directions = {nan_ray, 0}};
    mlrt_hits hits = {.struct_size = sizeof hits, .t = {&t, 0, 0}};
    mesh.vertex_count = 1;
    mlrt_build_tree(&mesh, 1, NULL, &tree);
    mlrt_build_tree(NULL, 0, NULL, &tree);
    mlrt_trace_packet(tree, &rays, NULL, &hits);
    mlrt_trace_packet(NULL, &rays, NULL, &hits);
    mlrt_destroy_tree(tree);
    fflush(NULL);
    dup2(out, 1);
    dup2(err, 2);
    close(out);
    close(err);
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    fclose(file);
    assert_int_equal(size, 0);
}

/* ---- the floating-point environment ------------------------------------------------------------------------------ */

/* Everything that the library computes, as bytes. */
struct answers {
    struct reference_hit packet[64];
    struct reference_hit single[64];
    struct reference_hit picture[20 * 20];
    uint8_t any[64];
    uint8_t any_pixel[20 * 20];
    uint8_t shadow[64];
    uint8_t directional[64];
    uint8_t pixel_shadow[20 * 20];
    float shadow_ray[2][6];
    int32_t faces[2];
    float list_t[4 * 64];
    uint8_t list_crossing[4 * 64];
    uint32_t list_total[64];
    float rays[3 * 20 * 20];
    float point[3];
    uint64_t tree_hash;
    uint64_t zero_area_count;
};

struct environment {
    struct soup soup;
    float origins[64][3];
    float directions[64][3];
    mlrt_camera camera;
    float eye[3]; /* of a ray that hits a denormal triangle */
    float to_denormals[3];
};

static void make_environment(struct environment *e)
{
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0}, zero[3] = {0, 0, 0};
    struct random random = {9};
    struct soup tiny = {0};
    memset(e, 0, sizeof *e);
    soup_add_random(&e->soup, &random, 150, 1, 0.4f);
    soup_add_random(&tiny, &random, 150, 1, 0.4f);
    move_soup(&tiny, 1e-39f, zero); // all of it denormal
    for (size_t i = 0; i < tiny.count; i++)
        soup_add_triangle(&e->soup, tiny.corners + 9 * i, tiny.corners + 9 * i + 3, tiny.corners + 9 * i + 6);
    free_soup(&tiny);
    for (int i = 0; i < 64; i++) {
        float scale = i % 2 ? 1e-39f : 1.0f;
        draw_point(&random, -2 * scale, 2 * scale, e->origins[i]);
        draw_point(&random, -scale, scale, e->directions[i]);
    }
    // Rays that raise an exception wherever somebody computes with them.
    e->origins[60][1] = float_of_bits(0x7FA00000); // a signalling NaN
    e->directions[61][2] = INFINITY;
    memset(e->directions[62], 0, sizeof e->directions[62]);
    for (int k = 0; k < 3; k++) e->directions[63][k] = 3e38f, e->origins[63][k] = -3e38f;
    const float *p = e->soup.corners + 9 * 150;
    for (int k = 0; k < 3; k++) {
        const double middle = ((double)p[k] + (double)p[k + 3] + (double)p[k + 6]) / 3;
        e->eye[k] = (float)(1e-38 * (k + 1));
        e->to_denormals[k] = (float)(1e38 * (middle - (double)e->eye[k]));
    }
    e->camera = look_at(eye, target, 1, 20, 20);
    e->camera.dx[0] = 1e-40f;
}

static int32_t compute_single(const struct environment *e, const mlrt_tree *tree, const mlrt_trace_options *options,
                              int i, struct reference_hit *out)
{
    mlrt_ray ray = {.struct_size = sizeof ray, .t_min = i % 8 ? 0 : 1e-40f};
    mlrt_hit hit = {.struct_size = sizeof hit};
    memcpy(ray.origin, e->origins[i], sizeof ray.origin);
    memcpy(ray.direction, e->directions[i], sizeof ray.direction);
    int32_t status = mlrt_trace_ray(tree, &ray, options, &hit);
    *out = (struct reference_hit){hit.t, hit.u, hit.v, hit.mesh, hit.triangle, hit.facing};
    return status;
}

/* That of the middle of the first triangle among the denormal ones. */
static int32_t compute_shadow_ray(const struct environment *e, const mlrt_tree *tree, const mlrt_light *light,
                                  int32_t *faces, float out[6])
{
    mlrt_ray ray = {.struct_size = sizeof ray}, shadow = {.struct_size = sizeof shadow};
    const mlrt_hit hit = {.struct_size = sizeof hit, .triangle = 150};
    for (int k = 0; k < 3; k++) { // without arithmetic on floats, which the caller's environment could change
        ray.origin[k] = e->eye[k];
        ray.direction[k] = e->to_denormals[k];
    }
    const int32_t status = mlrt_shadow_ray(tree, &ray, &hit, light, &shadow, faces);
    memcpy(out, shadow.origin, sizeof shadow.origin);
    memcpy(out + 3, shadow.direction, sizeof shadow.direction);
    return status;
}

/* Returns the sum of all statuses. */
static int32_t compute(const struct environment *e, mlrt_pool *pool, const struct variant *variant, struct answers *a)
{
    mlrt_tree *tree = NULL;
    mlrt_mesh mesh = soup_mesh(&e->soup);
    mlrt_tree_info info = {.struct_size = sizeof info};
    mlrt_trace_options options = variant->options;
    options.pool = pool;
    int32_t status =
        variant->on_kdtree ? mlrt_build_kdtree(&mesh, 1, NULL, &tree) : mlrt_build_tree(&mesh, 1, NULL, &tree);
    status += mlrt_get_tree_info(tree, &info);
    a->tree_hash = info.tree_hash;
    a->zero_area_count = info.zero_area_count;
    mlrt_rays rays = {
        .struct_size = sizeof rays, .count = 64, .origins = {e->origins, 0}, .directions = {e->directions, 0}};
    mlrt_hits hits = public_hits(a->packet, 0);
    mlrt_hits any = {.struct_size = sizeof any, .occluded = {a->any, 0, 0}};
    mlrt_hits frame = public_hits(a->picture, 20);
    mlrt_hits any_pixel = {.struct_size = sizeof any_pixel, .occluded = {a->any_pixel, 0, 0}};
    status += mlrt_trace_packet(tree, &rays, &options, &hits);
    status += mlrt_render_tiles(tree, &e->camera, &options, &frame, NULL, NULL);
    mlrt_hit_lists lists = {.struct_size = sizeof lists,
                            .capacity = 4,
                            .t = {a->list_t, 0, 0},
                            .crossing = {a->list_crossing, 0, 0},
                            .total = {a->list_total, 0, 0}};
    status += mlrt_trace_all_hits(tree, &rays, &options, &lists);
    for (int i = 0; i < 64; i++) status += compute_single(e, tree, &options, i, &a->single[i]);
    options.query = MLRT_QUERY_ANY;
    status += mlrt_trace_packet(tree, &rays, &options, &any);
    status += mlrt_render_tiles(tree, &e->camera, &options, &any_pixel, NULL, NULL);
    mlrt_array directions = {a->rays, 0, 0}, none = {NULL, 0, 0}, shadow = {a->shadow, 0, 0};
    status += mlrt_camera_rays(&e->camera, &none, &directions);
    mlrt_points points = {.struct_size = sizeof points, .count = 64, .positions = {e->origins, 0}};
    mlrt_light light = {.struct_size = sizeof light, .position = {1e-39f, 2e-39f, -1e-39f}};
    mlrt_light sun = {.struct_size = sizeof sun, .kind = MLRT_LIGHT_DIRECTIONAL, .position = {1e-39f, 1, 1e38f}};
    mlrt_array directional = {a->directional, 0, 0};
    status += mlrt_occluded_points(tree, &points, &light, &options, &shadow);
    status += mlrt_occluded_points(tree, &points, &sun, &options, &directional);
    const mlrt_light lights[2] = {light, sun};
    mlrt_hits shadows = {.struct_size = sizeof shadows, .occluded = {a->pixel_shadow, 0, 0}};
    options.query = MLRT_QUERY_CLOSEST;
    options.lights = lights;
    options.light_count = 2;
    status += mlrt_render_tiles(tree, &e->camera, &options, &shadows, NULL, NULL);
    for (int i = 0; i < 2; i++) status += compute_shadow_ray(e, tree, &lights[i], a->faces + i, a->shadow_ray[i]);
    for (uint32_t i = 0; i < 150; i += 149) status += mlrt_offset_point(tree, 0, 150 + i, 0.3f, 0.3f, 1, a->point);
    mlrt_destroy_tree(tree);
    return status;
}

#if HAS_MXCSR
/* The control bits of a strange caller: with them the library must give the same, and leave them. */
static void assert_same_under(unsigned int control)
{
    static struct answers plain, strange;
    struct environment e;
    make_environment(&e);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        if (!variant->probe && variant->options.method != MLRT_METHOD_RAY) continue;
        mlrt_pool *pool = shared_pool(variant->threads);
        memset(&plain, 0, sizeof plain);
        memset(&strange, 0, sizeof strange);
        assert_int_equal(compute(&e, pool, variant, &plain), 0);
        unsigned int before = _mm_getcsr();
        _mm_setcsr(control);
        int32_t status = compute(&e, pool, variant, &strange);
        unsigned int after = _mm_getcsr();
        _mm_setcsr(before);
        assert_int_equal(status, 0);
        assert_int_equal(after, control);
        assert_memory_equal(&plain, &strange, sizeof plain);
    }
    free_soup(&e.soup);
}

enum { MASKED = 0x1F80, FLUSH = 0x8000, DENORMALS_ARE_ZERO = 0x0040 };
#endif

static void callers_that_flush_denormals(void **state)
{
    (void)state;
#if HAS_MXCSR
    assert_same_under(MASKED | FLUSH | DENORMALS_ARE_ZERO);
#else
    skip();
#endif
}

static void callers_that_round_toward_zero(void **state)
{
    (void)state;
#if HAS_MXCSR
    assert_same_under(MASKED | 0x6000);
#else
    skip();
#endif
}

static void callers_that_round_up(void **state)
{
    (void)state;
#if HAS_MXCSR
    assert_same_under(MASKED | 0x4000);
#else
    skip();
#endif
}

static void callers_that_round_down(void **state)
{
    (void)state;
#if HAS_MXCSR
    assert_same_under(MASKED | 0x2000 | FLUSH);
#else
    skip();
#endif
}

/* Every exception would be a signal. */
static void callers_with_unmasked_exceptions(void **state)
{
    (void)state;
#if HAS_MXCSR
    assert_same_under(0);
#else
    skip();
#endif
}

/* By the portable way too, on machines with other control words. */
static void callers_that_round_by_fenv(void **state)
{
    (void)state;
    static const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
    static struct answers plain, strange;
    struct environment e;
    make_environment(&e);
    for (int on_kdtree = 0; on_kdtree <= 1; on_kdtree++) {
        const struct variant variant = {.options = {.struct_size = sizeof variant.options}, .on_kdtree = on_kdtree};
        memset(&plain, 0, sizeof plain);
        assert_int_equal(compute(&e, NULL, &variant, &plain), 0);
        for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
            memset(&strange, 0, sizeof strange);
            int before = fegetround();
            assert_int_equal(fesetround(modes[i]), 0);
            int32_t status = compute(&e, shared_pool(i ? 3 : 0), &variant, &strange);
            int after = fegetround();
            fesetround(before);
            assert_int_equal(status, 0);
            assert_int_equal(after, modes[i]);
            assert_memory_equal(&plain, &strange, sizeof plain);
        }
    }
    free_soup(&e.soup);
}

/* Exceptions as signals by the system's own function, which knows of every control word there is. */
static void callers_that_trap_by_fenv(void **state)
{
    (void)state;
#ifdef __GLIBC__
    static struct answers plain, strange;
    struct environment e;
    make_environment(&e);
    for (int on_kdtree = 0; on_kdtree <= 1; on_kdtree++) {
        const struct variant variant = {.options = {.struct_size = sizeof variant.options}, .on_kdtree = on_kdtree};
        memset(&plain, 0, sizeof plain);
        memset(&strange, 0, sizeof strange);
        assert_int_equal(compute(&e, NULL, &variant, &plain), 0);
        fexcept_t flags;
        fegetexceptflag(&flags, FE_ALL_EXCEPT);
        feclearexcept(FE_ALL_EXCEPT);
        if (feenableexcept(FE_ALL_EXCEPT) == -1) skip(); // a processor without traps
        int32_t status = compute(&e, NULL, &variant, &strange);
        int traps = fegetexcept(), raised = fetestexcept(FE_ALL_EXCEPT);
        fedisableexcept(FE_ALL_EXCEPT);
        fesetexceptflag(&flags, FE_ALL_EXCEPT);
        assert_int_equal(status, 0);
        assert_int_equal(traps, FE_ALL_EXCEPT);
        assert_int_equal(raised, 0);
        assert_memory_equal(&plain, &strange, sizeof plain);
    }
    free_soup(&e.soup);
#else
    skip();
#endif
}

static int32_t go_on(void *user, double fraction)
{
    (void)fraction;
    ++*(int *)user;
    return 0;
}

/* Counting what is done divides, and options are compared before anything is entered. */
static void progress_and_options_under_traps(void **state)
{
    (void)state;
#ifdef __GLIBC__
    int tell_count = 0;
    mlrt_tree *tree = some_tree(), *other = NULL;
    const mlrt_camera camera = good_camera();
    const mlrt_host host = {.struct_size = sizeof host, .user = &tell_count, .progress = go_on};
    const mlrt_trace_options trace = {.struct_size = sizeof trace, .host = &host, .initial_tile_size = 4};
    const mlrt_tree_options build = {.struct_size = sizeof build, .traversal_cost = NAN};
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    uint32_t ids[16];
    const mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {ids, 0, 0}};
    fexcept_t flags;
    fegetexceptflag(&flags, FE_ALL_EXCEPT);
    feclearexcept(FE_ALL_EXCEPT);
    if (feenableexcept(FE_ALL_EXCEPT) == -1) skip(); // a processor without traps
    const int32_t rendered = mlrt_render_tiles(tree, &camera, &trace, &frame, NULL, NULL);
    const int32_t built = mlrt_build_tree(NULL, 0, &build, &other);
    const int32_t estimated = mlrt_estimate_tree(NULL, 0, &build, &estimate);
    fedisableexcept(FE_ALL_EXCEPT);
    fesetexceptflag(&flags, FE_ALL_EXCEPT);
    assert_int_equal(rendered, MLRT_OK);
    assert_int_equal(built, MLRT_ERROR_ARGUMENT);
    assert_int_equal(estimated, MLRT_ERROR_ARGUMENT);
    assert_true(tell_count > 1);
    mlrt_destroy_tree(tree);
#else
    skip();
#endif
}

/*
 * A signalling NaN raises an exception wherever it is looked at. So no float of the caller's may be looked at before
 * the library's environment is there. What each call answers is compared at once: no test goes on with traps.
 */
#ifdef __GLIBC__
static const uint32_t signalling = 0x7FA00000;

static void set_bad(void *place)
{
    memcpy(place, &signalling, sizeof signalling);
}

/* Returns 0 on a processor without traps. */
static int begin_traps(fexcept_t *flags)
{
    fegetexceptflag(flags, FE_ALL_EXCEPT);
    feclearexcept(FE_ALL_EXCEPT);
    return feenableexcept(FE_INVALID) != -1;
}

static void end_traps(const fexcept_t *flags)
{
    const int traps = fegetexcept(), raised = fetestexcept(FE_INVALID);
    fedisableexcept(FE_ALL_EXCEPT);
    fesetexceptflag(flags, FE_ALL_EXCEPT);
    assert_int_equal(traps, FE_INVALID);
    assert_int_equal(raised, 0);
}

static void assert_answer(int32_t status, int32_t expected)
{
    if (status == expected) return;
    fedisableexcept(FE_ALL_EXCEPT);
    fail_msg("%s, not %s", mlrt_status_string(status), mlrt_status_string(expected));
}
#endif

static void a_point_of_signalling_nans(void **state)
{
    (void)state;
#ifdef __GLIBC__
    mlrt_tree *tree = some_tree();
    float bad, point[3];
    fexcept_t flags;
    set_bad(&bad);
    if (!begin_traps(&flags)) skip();
    assert_answer(mlrt_offset_point(tree, 0, 0, bad, 0.25f, 1, point), MLRT_ERROR_ARGUMENT);
    assert_answer(mlrt_offset_point(tree, 0, 0, 0.25f, bad, -1, point), MLRT_ERROR_ARGUMENT);
    end_traps(&flags);
    mlrt_destroy_tree(tree);
#else
    skip();
#endif
}

static void cameras_of_signalling_nans(void **state)
{
    (void)state;
#ifdef __GLIBC__
    static const size_t places[] = {
        offsetof(mlrt_camera, eye),      offsetof(mlrt_camera, direction), offsetof(mlrt_camera, d00),
        offsetof(mlrt_camera, dx),       offsetof(mlrt_camera, dy),        offsetof(mlrt_camera, sample_x),
        offsetof(mlrt_camera, sample_y), offsetof(mlrt_camera, t_min),     offsetof(mlrt_camera, t_max)};
    mlrt_tree *tree = some_tree();
    float vectors[16][3];
    uint32_t ids[16];
    const mlrt_array out = {vectors, 0, 0};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {ids, 0, 0}};
    fexcept_t flags;
    if (!begin_traps(&flags)) skip();
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        for (int32_t projection = MLRT_PROJECTION_PINHOLE; projection <= MLRT_PROJECTION_PARALLEL; projection++) {
            const size_t unused = projection == MLRT_PROJECTION_PARALLEL ? 0 : 1; // of eye and direction one counts
            const int32_t expected = i == unused ? MLRT_OK : MLRT_ERROR_CAMERA;
            mlrt_camera camera = good_camera();
            camera.projection = projection;
            camera.direction[2] = 1;
            set_bad((unsigned char *)&camera + places[i]);
            assert_answer(mlrt_camera_rays(&camera, &out, &out), expected);
            assert_answer(mlrt_render_tiles(tree, &camera, NULL, &hits, NULL, NULL), expected);
        }
    }
    end_traps(&flags);
    mlrt_destroy_tree(tree);
#else
    skip();
#endif
}

static void lights_of_signalling_nans(void **state)
{
    (void)state;
#ifdef __GLIBC__
    mlrt_tree *tree = some_tree();
    const mlrt_camera camera = good_camera();
    const mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    const mlrt_hit hit = {.struct_size = sizeof hit};
    const float positions[16][3] = {{0}};
    const mlrt_points points = {.struct_size = sizeof points, .count = 16, .positions = {positions, 0}};
    mlrt_ray shadow = {.struct_size = sizeof shadow};
    uint8_t occluded[16];
    int32_t faces;
    const mlrt_array out = {occluded, 0, 0};
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = out};
    fexcept_t flags;
    if (!begin_traps(&flags)) skip();
    for (int32_t kind = MLRT_LIGHT_POINT; kind <= MLRT_LIGHT_DIRECTIONAL; kind++) {
        mlrt_light light = {.struct_size = sizeof light, .kind = kind};
        const mlrt_trace_options options = {.struct_size = sizeof options, .lights = &light, .light_count = 1};
        set_bad(&light.position[1]);
        assert_answer(mlrt_occluded_points(tree, &points, &light, NULL, &out), MLRT_ERROR_ARGUMENT);
        assert_answer(mlrt_render_tiles(tree, &camera, &options, &hits, NULL, NULL), MLRT_ERROR_ARGUMENT);
        assert_answer(mlrt_shadow_ray(tree, &ray, &hit, &light, &shadow, &faces), MLRT_ERROR_ARGUMENT);
    }
    end_traps(&flags);
    mlrt_destroy_tree(tree);
#else
    skip();
#endif
}

static void rays_of_signalling_nans(void **state)
{
    (void)state;
#ifdef __GLIBC__
    static const int32_t methods[] = {MLRT_METHOD_DEFAULT, MLRT_METHOD_RAY, MLRT_METHOD_TILE};
    mlrt_tree *tree = some_tree();
    float good[16][3] = {{0}};
    const mlrt_light sun = {.struct_size = sizeof sun, .kind = MLRT_LIGHT_DIRECTIONAL, .position = {0, 0, 1}};
    const mlrt_hit seen = {.struct_size = sizeof seen};
    float bad[16][3];
    uint32_t ids[16];
    uint8_t occluded[16];
    int32_t faces;
    const mlrt_array out = {occluded, 0, 0};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {ids, 0, 0}};
    const mlrt_hit_lists lists = {.struct_size = sizeof lists, .capacity = 1, .triangle = {ids, 0, 0}};
    const mlrt_points points = {.struct_size = sizeof points, .count = 16, .positions = {bad, 0}};
    fexcept_t flags;
    for (int i = 0; i < 48; i++) set_bad(&bad[i / 3][i % 3]);
    if (!begin_traps(&flags)) skip();
    for (int i = 0; i < 4; i++) {
        mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
        mlrt_ray shadow = {.struct_size = sizeof shadow};
        void *const places[] = {&ray.origin[1], &ray.direction[2], &ray.t_min, &ray.t_max};
        const mlrt_rays rays = {.struct_size = sizeof rays,
                                .count = 16,
                                .origins = {i == 0 ? bad : good, 0},
                                .directions = {i == 1 ? bad : good, 0},
                                .t_min = {i == 2 ? bad : NULL, 0},
                                .t_max = {i == 3 ? bad : NULL, 0}};
        set_bad(places[i]);
        for (size_t m = 0; m < sizeof methods / sizeof methods[0]; m++) {
            const mlrt_trace_options options = {.struct_size = sizeof options, .method = methods[m]};
            mlrt_hit hit = {.struct_size = sizeof hit};
            assert_answer(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_OK);
            assert_answer(hit.triangle == MLRT_NONE, 1);
            assert_answer(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        }
        assert_answer(mlrt_trace_all_hits(tree, &rays, NULL, &lists), MLRT_OK);
        assert_answer(mlrt_shadow_ray(tree, &ray, &seen, &sun, &shadow, &faces), MLRT_ERROR_ARGUMENT);
    }
    assert_answer(mlrt_occluded_points(tree, &points, &sun, NULL, &out), MLRT_OK);
    end_traps(&flags);
    mlrt_destroy_tree(tree);
#else
    skip();
#endif
}

static void meshes_and_costs_of_signalling_nans(void **state)
{
    (void)state;
#ifdef __GLIBC__
    mlrt_tree *tree = NULL, *loaded = NULL;
    mlrt_tree_options build = {.struct_size = sizeof build};
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    mlrt_mesh mesh = two_triangles();
    float bad[18];
    size_t size = 0;
    uint64_t hash;
    unsigned char *file = allocate_or_fail(1, 100000);
    fexcept_t flags;
    memcpy(bad, corners, sizeof bad);
    set_bad(&bad[4]);
    mesh.vertices = bad;
    if (!begin_traps(&flags)) skip();
    assert_answer(mlrt_hash_geometry(&mesh, 1, &hash), MLRT_OK);
    assert_answer(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    assert_answer(mlrt_save_tree(tree, file, 100000, &size), MLRT_OK);
    assert_answer(mlrt_load_tree(file, size, NULL, &loaded), MLRT_OK);
    mlrt_destroy_tree(tree);
    mlrt_destroy_tree(loaded);
    for (int i = 0; i < 2; i++) {
        build.traversal_cost = build.intersection_cost = 0;
        set_bad(i == 0 ? &build.traversal_cost : &build.intersection_cost);
        assert_answer(mlrt_build_tree(&mesh, 1, &build, &tree), MLRT_ERROR_ARGUMENT);
        assert_answer(mlrt_estimate_tree(&mesh, 1, &build, &estimate), MLRT_ERROR_ARGUMENT);
    }
    end_traps(&flags);
    free(file);
#else
    skip();
#endif
}

/* A t_max of 0 is none, a denormal one is one, to callers too for whom it is 0. */
static void a_denormal_limit_is_a_limit(void **state)
{
    (void)state;
#if HAS_MXCSR
    const float low[9] = {0, 0, 1e-39f, 1, 0, 1e-39f, 0, 1, 1e-39f};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = low, .vertex_count = 3, .triangle_count = 1};
    const mlrt_ray ray = {
        .struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}, .t_max = 5e-40f};
    const struct fixture fixture = {.tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH),
                                    .kdtree = build_structure(&mesh, 1, MLRT_STRUCTURE_KDTREE)};
    for (int32_t method = MLRT_METHOD_DEFAULT; method <= MLRT_METHOD_TILE; method++) {
        const mlrt_trace_options options = {.struct_size = sizeof options, .method = method};
        mlrt_hit hit = {.struct_size = sizeof hit};
        const unsigned int before = _mm_getcsr();
        _mm_setcsr(before | FLUSH | DENORMALS_ARE_ZERO);
        const int32_t status = mlrt_trace_ray(method_tree(method, &fixture), &ray, &options, &hit);
        _mm_setcsr(before);
        assert_int_equal(status, MLRT_OK);
        assert_int_equal(hit.triangle, MLRT_NONE);
    }
    mlrt_destroy_tree(fixture.tree);
    mlrt_destroy_tree(fixture.kdtree);
#else
    skip();
#endif
}

#if HAS_MXCSR
/* Runs a task at once, where denormals are 0. */
static void *run_flushed(void *user, mlrt_task_function function, void *argument)
{
    const unsigned int before = _mm_getcsr();
    (void)user;
    _mm_setcsr(before | FLUSH | DENORMALS_ARE_ZERO);
    function(argument);
    _mm_setcsr(before);
    return NULL;
}

static void finish_flushed(void *user, void *task)
{
    (void)user, (void)task;
}

static unsigned char *build_and_save(const mlrt_mesh *mesh, mlrt_pool *pool, size_t *size)
{
    const mlrt_tree_options options = {.struct_size = sizeof options, .pool = pool};
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(mesh, 1, &options, &tree), MLRT_OK);
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, size), MLRT_OK);
    unsigned char *file = allocate_or_fail(*size, 1);
    assert_int_equal(mlrt_save_tree(tree, file, *size, size), MLRT_OK);
    mlrt_destroy_tree(tree);
    return file;
}
#endif

/* Every step of a build sets the environment: a leaf that a task writes has denormal corners as they are. */
static void tasks_that_flush_denormals_build_the_same(void **state)
{
    (void)state;
#if HAS_MXCSR
    enum { SIDE = 100 };
    const mlrt_pool_options options = {
        .struct_size = sizeof options, .thread_count = 2, .enqueue = run_flushed, .finish = finish_flushed};
    float *vertices = allocate_or_fail(9 * SIDE * SIDE, sizeof *vertices);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float x = (float)(i % SIDE), y = (float)(i / SIDE), z = (float)(1 + i % 7) * 1e-40f;
        const float triangle[9] = {x, y, z, x + 1, y, -z, x, y + 1, z};
        memcpy(vertices + 9 * (size_t)i, triangle, sizeof triangle);
    }
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = vertices,
                            .vertex_count = 3 * SIDE * SIDE,
                            .triangle_count = SIDE * SIDE};
    mlrt_pool *pool;
    size_t size, other_size;
    assert_int_equal(mlrt_create_pool_with_options(&options, &pool), MLRT_OK);
    unsigned char *file = build_and_save(&mesh, NULL, &size), *other = build_and_save(&mesh, pool, &other_size);
    assert_int_equal(size, other_size);
    assert_memory_equal(file, other, size);
    mlrt_destroy_pool(pool);
    free(file);
    free(other);
    free(vertices);
#else
    skip();
#endif
}

/*
 * A saved tree has a hash of its triangles, whose corners may be kept in units: those of denormal triangles, of huge
 * ones, and of both. To take them out of units is arithmetic, where denormals count and results are inexact.
 */
static void trees_are_saved_the_same_by_any_caller(void **state)
{
    (void)state;
#if HAS_MXCSR
    static const float scales[] = {1e-39f, 1e36f, 1};
    static const unsigned int controls[] = {MASKED | FLUSH | DENORMALS_ARE_ZERO, MASKED | 0x6000, 0};
    const float zero[3] = {0, 0, 0};
    for (size_t i = 0; i < 2 * (sizeof scales / sizeof *scales); i++) {
        struct random random = {i};
        struct soup soup = {0};
        mlrt_tree *tree;
        size_t size, other_size;
        soup_add_random(&soup, &random, 40, 1, 0.4f);
        move_soup(&soup, scales[i / 2], zero);
        const float *corner = soup.corners, one[3] = {corner[0], corner[1], corner[2]},
                    two[3] = {corner[3], corner[4], corner[5]};
        soup_add_triangle(&soup, one, two, zero);
        const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                                .vertices = soup.corners,
                                .vertex_count = 3 * soup.count,
                                .triangle_count = soup.count};
        assert_int_equal(i % 2 ? mlrt_build_kdtree(&mesh, 1, NULL, &tree) : mlrt_build_tree(&mesh, 1, NULL, &tree),
                         MLRT_OK);
        assert_int_equal(mlrt_save_tree(tree, NULL, 0, &size), MLRT_OK);
        unsigned char *file = allocate_or_fail(size, 1), *other = allocate_or_fail(size, 1);
        assert_int_equal(mlrt_save_tree(tree, file, size, &size), MLRT_OK);
        for (size_t k = 0; k < sizeof controls / sizeof *controls; k++) {
            const unsigned int before = _mm_getcsr();
            _mm_setcsr(controls[k]);
            const int32_t status = mlrt_save_tree(tree, other, size, &other_size);
            const unsigned int after = _mm_getcsr();
            _mm_setcsr(before);
            assert_int_equal(status, MLRT_OK);
            assert_int_equal(after, controls[k]);
            assert_memory_equal(file, other, size);
        }
        mlrt_destroy_tree(tree);
        free(file);
        free(other);
        free_soup(&soup);
    }
#else
    skip();
#endif
}

#if HAS_MXCSR
struct control_seen {
    unsigned int expected;
    int wrong;
};

static int32_t look_at_control(void *user, const mlrt_tile *tile)
{
    struct control_seen *seen = user;
    if (tile->worker == 0 && _mm_getcsr() != seen->expected) seen->wrong = 1;
    return 0;
}
#endif

/* The callback is the caller's code: on the caller's thread it runs in the caller's environment. */
static void callbacks_run_in_the_callers_environment(void **state)
{
    (void)state;
#if HAS_MXCSR
    mlrt_tree *tree = some_tree();
    mlrt_camera camera = good_camera();
    struct control_seen seen = {MASKED | FLUSH | 0x6000, 0};
    unsigned int before = _mm_getcsr();
    _mm_setcsr(seen.expected);
    int32_t status = mlrt_render_tiles(tree, &camera, NULL, NULL, look_at_control, &seen);
    _mm_setcsr(before);
    assert_int_equal(status, MLRT_OK);
    assert_int_equal(seen.wrong, 0);
    mlrt_destroy_tree(tree);
#else
    skip();
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(version_is_that_of_the_header),
        cmocka_unit_test(every_status_has_its_own_text),
        cmocka_unit_test(unknown_statuses_have_a_text),
        cmocka_unit_test(structs_have_no_padding),
        cmocka_unit_test(building_without_a_place_for_the_tree),
        cmocka_unit_test(building_without_meshes),
        cmocka_unit_test(mesh_struct_sizes),
        cmocka_unit_test(mesh_without_vertices),
        cmocka_unit_test(index_sizes),
        cmocka_unit_test(strides_that_are_not_multiples),
        cmocka_unit_test(strides_of_meshes_that_are_too_large),
        cmocka_unit_test(triangles_without_enough_vertices),
        cmocka_unit_test(indices_out_of_range),
        cmocka_unit_test(a_message_names_mesh_triangle_and_index),
        cmocka_unit_test(messages_fit_their_buffer),
        cmocka_unit_test(ids_that_clash),
        cmocka_unit_test(more_triangles_than_can_be_counted),
        cmocka_unit_test(sizes_end_with_fields),
        cmocka_unit_test(build_option_ranges),
        cmocka_unit_test(kdtree_option_ranges),
        cmocka_unit_test(options_out_of_range_are_named),
        cmocka_unit_test(options_of_the_other_builder_are_refused),
        cmocka_unit_test(builders_make_what_they_are_named_for),
        cmocka_unit_test(build_costs_must_be_finite_and_not_negative),
        cmocka_unit_test(max_references_bounds_the_tree),
        cmocka_unit_test(tree_info_counts_what_is_left_out),
        cmocka_unit_test(zero_area_is_decided_exactly),
        cmocka_unit_test(tree_info_bounds_are_those_of_usable_triangles),
        cmocka_unit_test(tree_info_of_an_empty_tree),
        cmocka_unit_test(tree_info_is_consistent),
        cmocka_unit_test(the_same_input_gives_the_same_tree),
        cmocka_unit_test(tree_info_errors),
        cmocka_unit_test(pool_errors),
        cmocka_unit_test(pools_know_their_threads),
        cmocka_unit_test(destroying_null_does_nothing),
        cmocka_unit_test(tracing_without_arguments),
        cmocka_unit_test(tracing_without_origins_or_directions),
        cmocka_unit_test(tracing_no_rays_needs_no_arrays),
        cmocka_unit_test(tracing_with_wrong_struct_sizes),
        cmocka_unit_test(reserved_fields_must_be_zero),
        cmocka_unit_test(too_many_rays),
        cmocka_unit_test(rows_longer_than_the_list),
        cmocka_unit_test(trace_codes_out_of_range),
        cmocka_unit_test(tile_sizes_out_of_range),
        cmocka_unit_test(one_ray_may_have_the_tiles_of_a_list),
        cmocka_unit_test(split_factors_out_of_range),
        cmocka_unit_test(counters_of_a_wrong_size),
        cmocka_unit_test(outputs_that_the_query_does_not_write),
        cmocka_unit_test(single_ray_errors),
        cmocka_unit_test(a_camera_that_is_good),
        cmocka_unit_test(cameras_of_size_zero),
        cmocka_unit_test(cameras_that_are_not_finite),
        cmocka_unit_test(cameras_that_span_no_picture),
        cmocka_unit_test(cameras_with_a_wrong_size_or_projection),
        cmocka_unit_test(crops_beyond_the_picture),
        cmocka_unit_test(pictures_that_are_too_large),
        cmocka_unit_test(meshes_that_are_too_large),
        cmocka_unit_test(rendering_without_arguments),
        cmocka_unit_test(strides_of_rays_and_hits_that_are_too_large),
        cmocka_unit_test(strides_of_pictures_and_points_that_are_too_large),
        cmocka_unit_test(occlusion_errors),
        cmocka_unit_test(lights_of_a_picture),
        cmocka_unit_test(pictures_without_lights_have_no_shadows),
        cmocka_unit_test(lights_that_are_wrong),
        cmocka_unit_test(lights_of_different_sizes),
        cmocka_unit_test(lights_where_there_are_none),
        cmocka_unit_test(shadow_rays_without_arguments),
        cmocka_unit_test(shadow_rays_with_wrong_struct_sizes),
        cmocka_unit_test(shadow_rays_of_wrong_lights_and_rays),
        cmocka_unit_test(shadow_rays_of_misses),
        cmocka_unit_test(shadow_rays_of_any_hit),
        cmocka_unit_test(shadow_rays_of_triangles_that_do_not_exist),
        cmocka_unit_test(shadow_rays_of_triangles_that_were_left_out),
        cmocka_unit_test(offset_errors),
        cmocka_unit_test(nothing_is_printed),
        cmocka_unit_test(callers_that_flush_denormals),
        cmocka_unit_test(callers_that_round_toward_zero),
        cmocka_unit_test(callers_that_round_up),
        cmocka_unit_test(callers_that_round_down),
        cmocka_unit_test(callers_with_unmasked_exceptions),
        cmocka_unit_test(callers_that_round_by_fenv),
        cmocka_unit_test(callers_that_trap_by_fenv),
        cmocka_unit_test(progress_and_options_under_traps),
        cmocka_unit_test(a_point_of_signalling_nans),
        cmocka_unit_test(cameras_of_signalling_nans),
        cmocka_unit_test(lights_of_signalling_nans),
        cmocka_unit_test(rays_of_signalling_nans),
        cmocka_unit_test(meshes_and_costs_of_signalling_nans),
        cmocka_unit_test(a_denormal_limit_is_a_limit),
        cmocka_unit_test(tasks_that_flush_denormals_build_the_same),
        cmocka_unit_test(trees_are_saved_the_same_by_any_caller),
        cmocka_unit_test(callbacks_run_in_the_callers_environment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
