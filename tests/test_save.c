/* SPDX-License-Identifier: MIT */
/*
 * Saving and loading: what comes back is what was saved, what is damaged is refused, and what someone made to look
 * whole is refused or can do no harm. The last is worth most in a build with sanitizers.
 */
#define _POSIX_C_SOURCE 200809L
#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "forged_files.h"
#include "invariants.h"
#include "bvh/node.h"
#include "job/structure.h"
#include "mlrta/kdtree.h"
#include "support.h"

/* ---- helpers ------------------------------------------------------------------------------------------------- */

struct file {
    unsigned char *data; /* at a multiple of 64, and nothing behind its end */
    size_t size;
    void *block;
};

static struct file make_file(size_t size)
{
    struct file file = {NULL, size, NULL};
    file.data = allocate_file(size, &file.block);
    return file;
}

static struct file save(const mlrt_tree *tree)
{
    size_t size = 0, written = 0;
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, &size), MLRT_OK);
    struct file file = make_file(size);
    memset(file.data, 0xA5, size);
    assert_int_equal(mlrt_save_tree(tree, file.data, size, &written), MLRT_OK);
    assert_int_equal(size, written);
    assert_int_equal(size % 64, 0);
    return file;
}

static struct file copy_file(const struct file *file)
{
    struct file copy = make_file(file->size);
    memcpy(copy.data, file->data, file->size);
    return copy;
}

static void free_file(struct file *file)
{
    free(file->block);
    *file = (struct file){NULL, 0, NULL};
}

static mlrt_tree *load(const void *data, size_t size, uint32_t flags)
{
    const mlrt_load_options options = {.struct_size = sizeof options, .flags = flags};
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_load_tree(data, size, &options, &tree), MLRT_OK);
    assert_non_null(tree);
    return tree;
}

static void assert_refused(const void *data, size_t size)
{
    for (uint32_t flags = 0; flags < 2; flags++) {
        const mlrt_load_options options = {.struct_size = sizeof options, .flags = flags};
        mlrt_tree *tree = (mlrt_tree *)(uintptr_t)16;
        assert_int_equal(mlrt_load_tree(data, size, &options, &tree), MLRT_ERROR_DATA);
        assert_null(tree);
    }
}

/* What tests below are given: each is run for boxes first, then for a kd-tree. */
static uint32_t boxes = MLRT_STRUCTURE_BVH, kdtree = MLRT_STRUCTURE_KDTREE;

#define OF_BOTH(test) cmocka_unit_test_prestate(test, &boxes), cmocka_unit_test_prestate(test, &kdtree)

static uint32_t structure_given(void **state)
{
    return *(const uint32_t *)*state;
}

static mlrt_tree *tree_of_soup(struct soup *soup, uint32_t structure)
{
    const mlrt_mesh mesh = soup_mesh(soup);
    mlrt_tree *tree = build_structure(&mesh, 1, structure);
    free_soup(soup);
    return tree;
}

static mlrt_tree *small_tree(uint32_t count, uint32_t structure)
{
    struct random random = {count};
    struct soup soup = {0};
    soup_add_random(&soup, &random, count, 1, 0.4f);
    return tree_of_soup(&soup, structure);
}

/* ---- what comes back ----------------------------------------------------------------------------------------- */

static mlrt_tree_info info_of(const mlrt_tree *tree)
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
    return info;
}

/* All but bytes and seconds, which are not the tree's. */
static void assert_same_info(const mlrt_tree *tree, const mlrt_tree *other)
{
    mlrt_tree_info info = info_of(tree), other_info = info_of(other);
    info.memory_size = info.peak_memory_size = other_info.memory_size = other_info.peak_memory_size = 0;
    info.build_seconds = other_info.build_seconds = 0;
    assert_memory_equal(&info, &other_info, sizeof info);
}

enum { SIDE = 24 };

static void trace_pixels(const mlrt_tree *tree, int32_t method, struct reference_hit hits[SIDE * SIDE])
{
    const mlrt_tree_info info = info_of(tree);
    float eye[3], target[3];
    for (int k = 0; k < 3; k++) {
        target[k] = info.bounds_min[k] / 2 + info.bounds_max[k] / 2;
        eye[k] = target[k] + (info.bounds_max[k] - info.bounds_min[k]) * (1 + 0.25f * (float)k);
    }
    if (eye[2] == target[2]) eye[2] += 1;
    const mlrt_camera camera = look_at(eye, target, 1.2f, SIDE, SIDE);
    const mlrt_trace_options options = {.struct_size = sizeof options, .method = method};
    const mlrt_hits frame = public_hits(hits, SIDE);
    const int32_t status = mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL);
    assert_true(status == MLRT_OK || status == MLRT_ERROR_UNSUPPORTED);
}

static void assert_same_answers(const mlrt_tree *tree, const mlrt_tree *other)
{
    static struct reference_hit hits[SIDE * SIDE], other_hits[SIDE * SIDE];
    for (int32_t method = MLRT_METHOD_DEFAULT; method <= MLRT_METHOD_TILE; method++) {
        memset(hits, 0, sizeof hits);
        memset(other_hits, 0, sizeof other_hits);
        trace_pixels(tree, method, hits);
        trace_pixels(other, method, other_hits);
        for (int i = 0; i < SIDE * SIDE; i++) assert_true(same_hit(&hits[i], &other_hits[i]));
    }
}

static void assert_same_file(const struct file *file, const mlrt_tree *tree)
{
    struct file again = save(tree);
    assert_int_equal(again.size, file->size);
    assert_memory_equal(again.data, file->data, file->size);
    free_file(&again);
}

static void assert_same_tree(const mlrt_tree *tree, const struct file *file, const mlrt_tree *loaded)
{
    assert_same_info(tree, loaded);
    assert_same_file(file, loaded);
    assert_same_answers(tree, loaded);
    assert_int_equal(tree->kdtree.float_safe, loaded->kdtree.float_safe);
    if (tree->bvh.node_count > 0)
        assert_memory_equal(&tree->bvh.unit, &loaded->bvh.unit, 2 * sizeof tree->bvh.unit + 2 * sizeof tree->bvh.core);
    assert_int_equal(tree->masks == NULL, loaded->masks == NULL);
    assert_true(loaded->kdtree.node_count == 0 || check_kdtree(loaded) == NULL);
    assert_true(loaded->bvh.node_count == 0 || check_bvh(loaded) == NULL);
}

/* Saves it, loads it in every way, and frees it. */
static void check_round_trips(mlrt_tree *tree)
{
    struct file file = save(tree);
    mlrt_tree *copied = load(file.data, file.size, 0), *in_place = load(file.data, file.size, MLRT_LOAD_IN_PLACE);
    assert_int_equal(in_place->borrowed, 1);
    assert_true(info_of(in_place).memory_size < 1000);
    assert_same_tree(tree, &file, in_place);
    assert_same_tree(tree, &file, copied);
    mlrt_destroy_tree(in_place);

    struct file moved = make_file(file.size + 64);
    for (size_t offset = 1; offset <= 32; offset *= 2) {
        memcpy(moved.data + offset, file.data, file.size);
        mlrt_tree *unaligned = load(moved.data + offset, file.size, offset == 8 ? 0 : MLRT_LOAD_IN_PLACE);
        assert_int_equal(unaligned->borrowed, 0);
        memset(moved.data, 0, moved.size);
        assert_same_file(&file, unaligned);
        if (offset == 4) assert_same_answers(tree, unaligned);
        mlrt_destroy_tree(unaligned);
    }
    free_file(&moved);
    free_file(&file);
    assert_same_answers(tree, copied); // the data are gone
    mlrt_destroy_tree(copied);
    mlrt_destroy_tree(tree);
}

static void check_kinds(const mlrt_mesh *meshes, size_t count)
{
    mlrt_tree *tree;
    for (int32_t preset = MLRT_TREE_DEFAULT; preset <= MLRT_TREE_BEST; preset++) {
        const mlrt_tree_options options = {.struct_size = sizeof options, .preset = preset};
        assert_int_equal(mlrt_build_tree(meshes, count, &options, &tree), MLRT_OK);
        check_round_trips(tree);
    }
    for (int32_t preset = MLRT_KDTREE_PAPER; preset <= MLRT_KDTREE_TUNED; preset++) {
        const mlrt_kdtree_options options = {.struct_size = sizeof options, .preset = preset};
        assert_int_equal(mlrt_build_kdtree(meshes, count, &options, &tree), MLRT_OK);
        check_round_trips(tree);
    }
}

static void check_soup(struct soup *soup)
{
    const mlrt_mesh mesh = soup_mesh(soup);
    check_kinds(&mesh, 1);
    free_soup(soup);
}

static void test_empty_trees_come_back(void **state)
{
    (void)state;
    const mlrt_mesh none = {.struct_size = sizeof none, .id = 5};
    const mlrt_mesh two[2] = {{.struct_size = sizeof none, .id = 9}, {.struct_size = sizeof none, .id = 5}};
    check_kinds(NULL, 0);
    check_kinds(&none, 1);
    check_kinds(two, 2);
}

static void test_one_triangle_comes_back(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 5}, b[3] = {1, 0, 5}, c[3] = {-0.0f, 1, 5};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    check_soup(&soup);
}

static void test_soups_come_back(void **state)
{
    (void)state;
    struct random random = {11};
    for (uint32_t count = 2; count <= 800; count += count) {
        struct soup soup = {0};
        soup_add_random(&soup, &random, count, 1, count % 3 ? 0.1f : 0.7f);
        check_soup(&soup);
    }
}

static void test_shapes_come_back(void **state)
{
    (void)state;
    struct random random = {12};
    const float offset[3] = {0, -0.0f, 0}, side[3] = {40, 0, 0}, other_side[3] = {0, 0.5f, 40};
    for (int shape = 0; shape < 6; shape++) {
        struct soup soup = {0};
        if (shape == 0) soup_add_icosphere(&soup, 2, 1);
        if (shape == 1) soup_add_torus(&soup, 20, 12, 2, 0.5f);
        if (shape == 2) soup_add_grid(&soup, 1, 3, 9);
        if (shape == 3) soup_add_needles(&soup, &random, 200, 1000);
        if (shape == 4) {
            soup_add_torus(&soup, 20, 12, 2, 0.5f);
            soup_add_quad(&soup, offset, side, other_side);
        }
        if (shape == 5) {
            for (int i = 0; i < 40; i++) soup_add_quad(&soup, offset, side, other_side);
        }
        check_soup(&soup);
    }
}

/* Where float is not safe, or hardly. */
static void test_huge_and_tiny_coordinates_come_back(void **state)
{
    (void)state;
    const float scales[] = {0x1p-140f, 0x1p-70f, 0x1p59f, 0x1p61f, 0x1p100f};
    const float offset[3] = {0, 0, 0};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        struct random random = {13};
        struct soup soup = {0};
        soup_add_random(&soup, &random, 100, 1, 0.3f);
        move_soup(&soup, scales[i], offset);
        check_soup(&soup);
    }
}

static void test_left_out_triangles_come_back(void **state)
{
    (void)state;
    struct random random = {14};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 300, 1, 0.3f);
    for (int i = 0; i < 300; i += 5) soup.corners[9 * i + i % 9] = i % 2 ? NAN : INFINITY;
    for (int i = 1; i < 300; i += 7) memcpy(soup.corners + 9 * i, soup.corners + 9 * i + 3, 12);
    check_soup(&soup);
    soup_add_random(&soup, &random, 3, 1, 0.3f);
    for (int i = 0; i < 27; i++) soup.corners[i] = NAN;
    check_soup(&soup);
}

#define MESH_COUNT 5

/* Meshes with ids in no order; the second and the last have no triangles. */
static void list_meshes(const struct soup *soup, mlrt_mesh meshes[MESH_COUNT])
{
    static const uint32_t ids[MESH_COUNT] = {70, 3, 0xFFFFFFFEu, 0, 12};
    static const size_t ends[MESH_COUNT] = {10, 10, 25, 40, 40};
    for (int i = 0; i < MESH_COUNT; i++) {
        const size_t first = i > 0 ? ends[i - 1] : 0;
        meshes[i] = (mlrt_mesh){.struct_size = sizeof *meshes,
                                .id = ids[i],
                                .vertices = soup->corners + 9 * first,
                                .vertex_count = 3 * (ends[i] - first),
                                .triangle_count = ends[i] - first};
    }
}

static void test_meshes_come_back(void **state)
{
    (void)state;
    struct random random = {15};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, 1, 0.5f);
    mlrt_mesh meshes[MESH_COUNT];
    list_meshes(&soup, meshes);
    check_kinds(meshes, MESH_COUNT);
    for (int i = 0; i < MESH_COUNT; i++) meshes[i].id = 0;
    check_kinds(meshes, MESH_COUNT);
    free_soup(&soup);
}

/* Masks as a builder makes them, or would. */
static void give_masks(mlrt_tree *tree, const uint32_t masks[MESH_COUNT])
{
    if (tree->masks == NULL) tree->masks = mlrt_allocate(&tree->memory, tree->triangle_count, sizeof *tree->masks);
    for (uint32_t mesh = 0; mesh < tree->meshes.count; mesh++) {
        for (uint32_t i = tree->meshes.first[mesh]; i < tree->meshes.first[mesh + 1]; i++) tree->masks[i] = masks[mesh];
    }
}

static void test_masks_come_back(void **state)
{
    (void)state;
    static const uint32_t masks[MESH_COUNT] = {1, 2, 0x80000000u, 6, 7};
    struct random random = {16};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, 1, 0.5f);
    mlrt_mesh meshes[MESH_COUNT];
    list_meshes(&soup, meshes);
    for (int i = 0; i < MESH_COUNT; i++) meshes[i].mask = masks[i];
    for (uint32_t structure = MLRT_STRUCTURE_KDTREE; structure <= MLRT_STRUCTURE_BVH; structure++) {
        mlrt_tree *tree = build_structure(meshes, MESH_COUNT, structure);
        give_masks(tree, masks);
        struct file file = save(tree);
        for (uint32_t flags = 0; flags < 2; flags++) {
            mlrt_tree *loaded = load(file.data, file.size, flags);
            assert_memory_equal(loaded->masks, tree->masks, 40 * sizeof *tree->masks);
            mlrt_destroy_tree(loaded);
        }
        free_file(&file);
        check_round_trips(tree);
    }
    free_soup(&soup);
}

/* Loaded trees against the reference, as built ones are tested. */
static void test_loaded_trees_answer_like_built_ones(void **state)
{
    (void)state;
    struct random random = {17};
    struct soup soup = {0};
    soup_add_torus(&soup, 24, 16, 2, 0.6f);
    soup_add_random(&soup, &random, 100, 3, 0.5f);
    struct fixture fixture = fixture_of_soup("loaded", 17, &soup);
    struct file file = save(fixture.tree), kdtree_file = save(fixture.kdtree);
    mlrt_destroy_tree(fixture.tree);
    mlrt_destroy_tree(fixture.kdtree);
    fixture.tree = load(file.data, file.size, MLRT_LOAD_IN_PLACE);
    fixture.kdtree = load(kdtree_file.data, kdtree_file.size, 0);
    struct ray_list list = {0};
    add_mixed_rays(&list, &random, &fixture, scaled(100), -3, 3);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
    free_file(&file);
    free_file(&kdtree_file);
}

static void test_a_scene_comes_back(void **state)
{
    (void)state;
    struct fixture fixture = fixture_of_example("scan:4000");
    check_round_trips(fixture.tree);
    check_round_trips(fixture.kdtree);
    fixture.tree = fixture.kdtree = NULL;
    free_fixture(&fixture);
}

static void test_a_mapped_file_will_do(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(500, structure);
    struct file file = save(tree);
    FILE *stream = tmpfile();
    assert_non_null(stream);
    assert_int_equal(fwrite(file.data, 1, file.size, stream), file.size);
    assert_int_equal(fflush(stream), 0);
    void *mapped = mmap(NULL, file.size, PROT_READ, MAP_PRIVATE, fileno(stream), 0);
    assert_true(mapped != MAP_FAILED);
    mlrt_tree *loaded = load(mapped, file.size, MLRT_LOAD_IN_PLACE);
    assert_int_equal(loaded->borrowed, 1);
    assert_same_tree(tree, &file, loaded);
    exercise_tree(loaded, 1);
    mlrt_destroy_tree(loaded);
    munmap(mapped, file.size);
    fclose(stream);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_equal_trees_are_equal_files(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(200, structure), *other = small_tree(200, structure);
    struct file file = save(tree);
    assert_same_file(&file, other);
    free_file(&file);
    mlrt_destroy_tree(tree);
    mlrt_destroy_tree(other);
}

/* ---- arguments ----------------------------------------------------------------------------------------------- */

static void test_a_buffer_that_is_too_small_stays_as_it_is(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(50, structure);
    size_t size = 0, needed = 0;
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, &size), MLRT_OK);
    struct file file = make_file(size - 1);
    memset(file.data, 0xA5, file.size);
    assert_int_equal(mlrt_save_tree(tree, file.data, size - 1, &needed), MLRT_ERROR_ARGUMENT);
    assert_int_equal(needed, size);
    assert_int_equal(mlrt_save_tree(tree, file.data, 0, &needed), MLRT_ERROR_ARGUMENT);
    for (size_t i = 0; i < file.size; i++) assert_int_equal(file.data[i], 0xA5);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_saving_works_at_any_address_and_in_larger_buffers(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(50, structure);
    struct file file = save(tree), room = make_file(file.size + 10);
    for (size_t offset = 0; offset < 8; offset++) {
        size_t size = 0;
        memset(room.data, 0x5A, room.size);
        assert_int_equal(mlrt_save_tree(tree, room.data + offset, room.size - offset, &size), MLRT_OK);
        assert_int_equal(size, file.size);
        assert_memory_equal(room.data + offset, file.data, size);
        for (size_t i = offset + size; i < room.size; i++) assert_int_equal(room.data[i], 0x5A);
    }
    free_file(&room);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_arguments_are_checked(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(5, structure), *loaded = (mlrt_tree *)(uintptr_t)16;
    struct file file = save(tree);
    size_t size = 1;
    assert_int_equal(mlrt_save_tree(NULL, NULL, 0, &size), MLRT_ERROR_ARGUMENT);
    assert_int_equal(size, 0);
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_load_tree(file.data, file.size, NULL, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_load_tree(NULL, file.size, NULL, &loaded), MLRT_ERROR_ARGUMENT);
    assert_null(loaded);
    mlrt_load_options options = {.struct_size = 4};
    assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_ERROR_STRUCT_SIZE);
    options = (mlrt_load_options){.struct_size = sizeof options, .flags = 2};
    assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_load_tree(file.data, file.size, NULL, &loaded), MLRT_OK);
    mlrt_destroy_tree(loaded);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_messages_say_what_is_wrong(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(5, structure), *loaded = NULL;
    struct file file = save(tree);
    char message[64] = "?";
    mlrt_load_options options = {.struct_size = sizeof options, .message = message, .message_size = sizeof message};
    assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_OK);
    assert_string_equal(message, "");
    mlrt_destroy_tree(loaded);
    file.data[FILE_VERSION]++;
    assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_ERROR_DATA);
    assert_non_null(strstr(message, "version"));
    options.message_size = 5;
    assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_ERROR_DATA);
    assert_int_equal(strlen(message), 4);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_running_out_of_memory_leaves_nothing(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(100, structure);
    struct file file = save(tree);
    const uint64_t memory_size = info_of(tree).memory_size;
    uint64_t limit = 1;
    mlrt_tree *loaded = NULL;
    for (;; limit += 40) {
        const mlrt_load_options options = {.struct_size = sizeof options, .memory_limit = limit};
        const int32_t status = mlrt_load_tree(file.data, file.size, &options, &loaded);
        if (status == MLRT_OK) break;
        assert_int_equal(status, MLRT_ERROR_OUT_OF_MEMORY);
        assert_null(loaded);
        assert_true(limit < memory_size);
    }
    assert_true(limit + 1000 > memory_size);
    assert_same_tree(tree, &file, loaded);
    mlrt_destroy_tree(loaded);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

/* A host whose memory ends after some blocks. */
struct host_memory {
    size_t left; /* blocks */
    size_t held_size;
    size_t line_count;
};

static void *allocate_some(void *user, size_t size, size_t alignment)
{
    struct host_memory *memory = user;
    void *block = NULL;
    if (memory->left == 0) return NULL;
    memory->left--;
    memory->held_size += size;
    assert_int_equal(posix_memalign(&block, alignment < sizeof(void *) ? sizeof(void *) : alignment, size), 0);
    return block;
}

static void free_some(void *user, void *block, size_t size, size_t alignment)
{
    struct host_memory *memory = user;
    (void)alignment;
    assert_true(size <= memory->held_size);
    memory->held_size -= size;
    free(block);
}

static void count_line(void *user, int32_t level, const char *message)
{
    struct host_memory *memory = user;
    assert_int_equal(level, MLRT_LOG_ERROR);
    assert_true(strlen(message) > 0);
    memory->line_count++;
}

static void test_a_host_whose_memory_ends_gets_all_of_it_back(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(100, structure);
    struct file file = save(tree), damaged = copy_file(&file);
    damaged.data[file.size / 2] ^= 1;
    for (uint32_t flags = 0; flags < 2; flags++) {
        struct host_memory memory = {0, 0, 0};
        const mlrt_host host = {.struct_size = sizeof host,
                                .user = &memory,
                                .allocate = allocate_some,
                                .free = free_some,
                                .log = count_line};
        const mlrt_load_options options = {.struct_size = sizeof options, .flags = flags, .host = &host};
        mlrt_tree *loaded = NULL;
        size_t blocks = 0;
        for (;; blocks++) {
            memory.left = blocks;
            const int32_t status = mlrt_load_tree(file.data, file.size, &options, &loaded);
            if (status == MLRT_OK) break;
            assert_int_equal(status, MLRT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(memory.held_size, 0);
            assert_int_equal(memory.line_count, blocks + 1);
        }
        assert_true(flags ? blocks == 1 : blocks > 5);
        assert_int_equal(memory.held_size, info_of(loaded).memory_size);
        mlrt_destroy_tree(loaded);
        assert_int_equal(memory.held_size, 0);
        memory.left = 100;
        assert_int_equal(mlrt_load_tree(damaged.data, damaged.size, &options, &loaded), MLRT_ERROR_DATA);
        assert_int_equal(memory.held_size, 0);
    }
    free_file(&damaged);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_the_floating_point_environment_does_not_matter(void **state)
{
    const uint32_t structure = structure_given(state);
    const float offset[3] = {0, 0, 0};
    struct random random = {18};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 100, 1, 0.3f);
    move_soup(&soup, 0x1p-135f, offset);
    mlrt_tree *tree = tree_of_soup(&soup, structure);
    struct file file = save(tree);
    const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
    for (int i = 0; i < 3; i++) {
        fesetround(modes[i]);
        mlrt_tree *loaded = load(file.data, file.size, 0);
        assert_int_equal(fegetround(), modes[i]);
        assert_same_file(&file, loaded);
        mlrt_destroy_tree(loaded);
    }
    fesetround(FE_TONEAREST);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

/* ---- the hash of a geometry ---------------------------------------------------------------------------------- */

static uint64_t hash_of(const mlrt_mesh *meshes, size_t count)
{
    uint64_t hash = 0;
    assert_int_equal(mlrt_hash_geometry(meshes, count, &hash), MLRT_OK);
    return hash;
}

static void test_the_geometry_hash_is_that_of_the_file(void **state)
{
    (void)state;
    struct random random = {19};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, 1, 0.5f);
    soup.corners[30] = NAN;
    mlrt_mesh meshes[MESH_COUNT];
    list_meshes(&soup, meshes);
    for (size_t count = 0; count <= MESH_COUNT; count++) {
        mlrt_tree *tree = build_structure(meshes, count, MLRT_STRUCTURE_BVH), *loaded = NULL;
        struct file file = save(tree);
        uint64_t stored;
        memcpy(&stored, file.data + FILE_GEOMETRY_HASH, sizeof stored);
        assert_true(stored == hash_of(meshes, count));
        mlrt_load_options options = {.struct_size = sizeof options, .geometry_hash = stored};
        assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_OK);
        mlrt_destroy_tree(loaded);
        options.geometry_hash++;
        assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_ERROR_DATA);
        memcpy(file.data + FILE_GEOMETRY_HASH, &options.geometry_hash, sizeof stored); // a lie in the header
        repair_hash(file.data, file.size);
        assert_int_equal(mlrt_load_tree(file.data, file.size, &options, &loaded), MLRT_ERROR_DATA);
        free_file(&file);
        mlrt_destroy_tree(tree);
    }
    free_soup(&soup);
}

static void test_the_geometry_hash_knows_masks(void **state)
{
    (void)state;
    static const uint32_t masks[MESH_COUNT] = {1, 2, 0x80000000u, 6, 7};
    struct random random = {20};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, 1, 0.5f);
    mlrt_mesh meshes[MESH_COUNT];
    list_meshes(&soup, meshes);
    const uint64_t without = hash_of(meshes, MESH_COUNT);
    for (int i = 0; i < MESH_COUNT; i++) meshes[i].mask = 0xFFFFFFFFu;
    assert_true(hash_of(meshes, MESH_COUNT) == without);
    for (int i = 0; i < MESH_COUNT; i++) meshes[i].mask = masks[i];
    assert_true(hash_of(meshes, MESH_COUNT) != without);
    mlrt_tree *tree = build_structure(meshes, MESH_COUNT, MLRT_STRUCTURE_BVH);
    give_masks(tree, masks);
    struct file file = save(tree);
    uint64_t stored;
    memcpy(&stored, file.data + FILE_GEOMETRY_HASH, sizeof stored);
    assert_true(stored == hash_of(meshes, MESH_COUNT));
    free_file(&file);
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

static void test_the_geometry_hash_does_not_depend_on_layout(void **state)
{
    (void)state;
    const float vertices[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    const float wide[4][5] = {{0, 0, 0, 9, 9}, {1, 0, 0, 8, 8}, {0, 1, 0, 7, 7}, {1, 1, 0, 6, 6}};
    const uint32_t indices[6] = {0, 1, 2, 2, 1, 3};
    const uint16_t short_indices[2][4] = {{0, 1, 2, 55}, {2, 1, 3, 66}};
    const float flat[6][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
    const mlrt_mesh meshes[] = {
        {.struct_size = sizeof *meshes,
         .vertices = vertices,
         .vertex_count = 4,
         .indices = indices,
         .triangle_count = 2},
        {.struct_size = sizeof *meshes,
         .vertices = wide,
         .vertex_count = 4,
         .vertex_stride = 20,
         .indices = short_indices,
         .triangle_count = 2,
         .triangle_stride = 8,
         .index_size = 2},
        {.struct_size = sizeof *meshes, .vertices = flat, .vertex_count = 6, .triangle_count = 2},
    };
    assert_true(hash_of(&meshes[0], 1) == hash_of(&meshes[1], 1));
    assert_true(hash_of(&meshes[0], 1) == hash_of(&meshes[2], 1));
    mlrt_mesh other = meshes[0];
    other.id = 1;
    assert_true(hash_of(&other, 1) != hash_of(&meshes[0], 1));
    other = meshes[0];
    other.triangle_count = 1;
    assert_true(hash_of(&other, 1) != hash_of(&meshes[0], 1));
    // The same triangles in two meshes.
    mlrt_mesh halves[2] = {other, other};
    halves[1].indices = indices + 3;
    assert_true(hash_of(halves, 2) != hash_of(&meshes[0], 1));
    // Ids that are positions.
    const uint64_t by_position = hash_of(halves, 2);
    halves[1].id = 1;
    assert_true(hash_of(halves, 2) == by_position);
    // -0 is not the same bits.
    float changed[4][3];
    memcpy(changed, vertices, sizeof changed);
    changed[2][2] = -0.0f;
    other = meshes[0];
    other.vertices = changed;
    assert_true(hash_of(&other, 1) != hash_of(&meshes[0], 1));
}

static void test_the_geometry_hash_checks_meshes(void **state)
{
    (void)state;
    const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    const uint32_t indices[3] = {0, 1, 3};
    mlrt_mesh mesh = {
        .struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .indices = indices, .triangle_count = 1};
    uint64_t hash = 1;
    assert_int_equal(mlrt_hash_geometry(&mesh, 1, &hash), MLRT_ERROR_INDEX_RANGE);
    assert_true(hash == 0);
    assert_int_equal(mlrt_hash_geometry(&mesh, 1, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_hash_geometry(NULL, 1, &hash), MLRT_ERROR_ARGUMENT);
    mesh.index_size = 3;
    assert_int_equal(mlrt_hash_geometry(&mesh, 1, &hash), MLRT_ERROR_ARGUMENT);
    mesh.struct_size = 4;
    assert_int_equal(mlrt_hash_geometry(&mesh, 1, &hash), MLRT_ERROR_STRUCT_SIZE);
    assert_int_equal(mlrt_hash_geometry(NULL, 0, &hash), MLRT_OK);
}

/* ---- damage -------------------------------------------------------------------------------------------------- */

static uint32_t word_at(const struct file *file, size_t offset)
{
    uint32_t word;
    memcpy(&word, file->data + offset, sizeof word);
    return word;
}

static void test_every_shorter_file_is_refused(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(20, structure);
    struct file file = save(tree);
    for (size_t size = 0; size < file.size; size++) {
        struct file part = make_file(size);
        memcpy(part.data, file.data, size);
        assert_refused(part.data, size);
        free_file(&part);
    }
    struct file longer = make_file(file.size + 64);
    memset(longer.data, 0, longer.size);
    memcpy(longer.data, file.data, file.size);
    assert_refused(longer.data, file.size + 1);
    assert_refused(longer.data, file.size + 64);
    free_file(&longer);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_every_changed_byte_is_noticed(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(20, structure);
    struct file file = save(tree);
    for (size_t i = 0; i < file.size; i++) {
        for (int bit = 0; bit < 8; bit += 1 + (int)(i % 3)) {
            file.data[i] ^= (unsigned char)(1 << bit);
            assert_refused(file.data, file.size);
            file.data[i] ^= (unsigned char)(1 << bit);
        }
        file.data[i] ^= 0xFF;
        assert_refused(file.data, file.size);
        file.data[i] ^= 0xFF;
    }
    mlrt_destroy_tree(load(file.data, file.size, 0));
    free_file(&file);
    mlrt_destroy_tree(tree);
}

static void test_other_orders_and_versions_are_refused(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *tree = small_tree(20, structure);
    struct file file = save(tree), other = copy_file(&file);
    for (size_t i = 0; i < file.size; i++) other.data[i] = file.data[i < 8 ? i : i ^ 3];
    repair_hash(other.data, other.size);
    assert_refused(other.data, other.size);
    for (uint32_t version = 0; version < 1000; version++) {
        if (version == word_at(&file, FILE_VERSION)) continue;
        memcpy(other.data, file.data, file.size);
        memcpy(other.data + FILE_VERSION, &version, sizeof version);
        repair_hash(other.data, other.size);
        assert_refused(other.data, other.size);
    }
    memset(other.data, 0, other.size);
    assert_refused(other.data, other.size);
    free_file(&other);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

/* ---- forgery: files whose hash is right ---------------------------------------------------------------------- */

static uint64_t number_at(const struct file *file, size_t offset)
{
    uint64_t number;
    memcpy(&number, file->data + offset, sizeof number);
    return number;
}

static void put_word(struct file *file, size_t offset, uint32_t word)
{
    memcpy(file->data + offset, &word, sizeof word);
}

/* Every word of the header, which the hash does not save here, is what it is for a reason, or does not matter. */
static void test_forged_headers_are_refused(void **state)
{
    const uint32_t structure = structure_given(state);
    static const uint32_t values[] = {0,           1,           2,           3,           0x7FFFFFFFu, 0x80000000u,
                                      0xFFFFFFFFu, 0x40000000u, 0x3FFFFFFFu, 0x1FFFFFFFu, 0x10000000u};
    mlrt_tree *tree = small_tree(20, structure);
    struct file file = save(tree);
    for (size_t offset = 0; offset < FILE_HEADER_SIZE; offset += 4) {
        const uint32_t word = word_at(&file, offset);
        const int is_hash = offset >= FILE_HASH && offset < FILE_GEOMETRY_HASH + 8;
        const int is_report = offset >= FILE_INFO && offset < FILE_SECTIONS;
        for (size_t i = 0; i < sizeof values / sizeof *values + 4; i++) {
            const uint32_t around[4] = {word + 1, word - 1, word + 64, word << 1};
            const uint32_t value = i < 4 ? around[i] : values[i - 4];
            if (value == word || is_hash) continue;
            put_word(&file, offset, value);
            repair_hash(file.data, file.size);
            if (is_report) {
                load_and_exercise(file.data, file.size, 1, i);
            } else {
                assert_refused(file.data, file.size);
            }
        }
        put_word(&file, offset, word);
    }
    free_file(&file);
    mlrt_destroy_tree(tree);
}

/* A copy of a tree to change at will. */
struct forgery {
    mlrt_tree *tree;
    const char *name;
};

static int is_accepted(const mlrt_tree *tree)
{
    struct file file = save(tree);
    const int accepted = load_and_exercise(file.data, file.size, 1, 5);
    assert_int_equal(load_and_exercise(file.data, file.size, 0, 6), accepted);
    free_file(&file);
    return accepted;
}

/* Coordinate i of a triangle, where the tree has it. */
static float *coordinate_of(const mlrt_tree *tree, uint32_t number, uint32_t i)
{
    if (tree->triangles) return &tree->triangles[number].v[i / 3][i % 3];
    const uint32_t packed = tree->bvh.places[number];
    return &tree->bvh.corners[36 * (size_t)mlrt_first_quad_of(packed) + mlrt_place_in_leaf(packed) +
                              4 * i * mlrt_quad_count_of(packed)];
}

/* Gives a hierarchy of boxes an array of triangles in place of places. Free the array, and restore tree->bvh. */
static void put_in_order(mlrt_tree *tree)
{
    struct mlrt_triangle *triangles = allocate_or_fail(tree->triangle_count, sizeof *triangles);
    for (uint32_t i = 0; i < tree->triangle_count; i++) triangles[i] = mlrt_triangle_at(&tree->by_number, i);
    tree->triangles = triangles;
    tree->bvh.places = NULL;
    tree->bvh.quad_count = tree->bvh.leaf_quad_count;
    mlrt_find_triangles(tree);
}

/* Frees the array of put_in_order, and gives the tree its hierarchy back. */
static void put_back(mlrt_tree *tree, const struct mlrt_bvh *kept)
{
    free(tree->triangles);
    tree->triangles = NULL;
    tree->bvh = *kept;
    mlrt_find_triangles(tree);
}

/* The leaf that a slot of the root or of a node below is; slots of nodes are numbered. */
static uint32_t *find_slot(const mlrt_tree *tree, int leaf, uint32_t skipped)
{
    for (uint32_t i = 0; i < tree->bvh.node_count * MLRT_BVH_WIDTH; i++) {
        uint32_t *child = &tree->bvh.nodes[i / MLRT_BVH_WIDTH].child[i % MLRT_BVH_WIDTH];
        if (*child != 0 && (mlrt_bvh_quad_count(*child) != 0) == leaf && skipped-- == 0) return child;
    }
    fail_msg("no such slot");
    return NULL;
}

static struct mlrt_node *find_node(const mlrt_tree *tree, int leaf, uint32_t skipped)
{
    for (uint32_t i = 0; i < tree->kdtree.node_count; i++) {
        struct mlrt_node *node = &tree->kdtree.nodes[i];
        if (mlrt_node_is_leaf(node) == leaf && (!leaf || mlrt_leaf_count(node) > 1) && skipped-- == 0) return node;
    }
    fail_msg("no such node");
    return NULL;
}

/* Each makes one thing wrong. `word` is a value to make it wrong with. */
enum forged_thing {
    BOX_CYCLE,
    BOX_CHILD_TWICE,
    BOX_CHILD_FAR,
    BOX_QUADS_FAR,
    BOX_QUADS_TWICE,
    BOX_QUADS_MANY,
    BOX_NO_CHILDREN,
    BOX_GAP,
    BOX_FULL_EMPTY_SLOT,
    BOX_NAN_LO,
    BOX_NAN_HI,
    BOX_INFINITE,
    BOX_INSIDE_OUT,
    BOX_BEYOND_BOUNDS,
    BOX_NAN_EMPTY_SLOT,
    NUMBER_FAR,
    NUMBER_TWICE,
    NUMBER_NONE_FIRST,
    NUMBER_BEHIND_NONE,
    CORNER,
    CORNER_OF_NOBODY,
    NODE_CYCLE,
    NODE_BACK,
    NODE_FAR,
    NODE_CHILD_TWICE,
    NODE_PLANE_NAN,
    NODE_PLANE_INFINITE,
    NODE_PLANE_OUTSIDE,
    NODE_LEAF_FAR,
    NODE_LEAF_MANY,
    NODE_LEAF_TWICE,
    NODE_LEAF_EARLY,
    ENTRY_FAR,
    ENTRY_TWICE,
    ENTRY_NONE,
    MESH_START,
    MESH_BACK,
    MESH_END,
    MESH_ID_TWICE,
    MESH_ID_NONE,
    MESH_POSITION,
    MESH_POSITION_TWICE,
    TRIANGLE_NAN,
    TRIANGLE_NAN_UNCOUNTED,
    TRIANGLE_FLAT,
    TRIANGLE_FLAT_UNCOUNTED,
    TRIANGLE_ELSEWHERE,
    BOUNDS_LARGER,
    BOUNDS_NAN,
    THING_COUNT
};

/* What a thing is of: MLRT_STRUCTURE_*, or 0 if trees of both have it. */
static uint32_t structure_of(enum forged_thing thing)
{
    if (thing <= CORNER_OF_NOBODY || thing == TRIANGLE_ELSEWHERE) return MLRT_STRUCTURE_BVH;
    return thing <= ENTRY_NONE ? MLRT_STRUCTURE_KDTREE : 0;
}

/*
 * The first triangle of a quad that has its place in another leaf; there must be one. Its corner begins at 9 times it.
 */
static uint32_t find_shared_place(const mlrt_tree *tree)
{
    for (uint32_t i = 0; i < 4 * tree->bvh.leaf_quad_count; i += 4) {
        const uint32_t packed = tree->bvh.places[tree->bvh.numbers[i]];
        if (4 * mlrt_first_quad_of(packed) + mlrt_place_in_leaf(packed) != i) return i;
    }
    fail_msg("each triangle is in one leaf");
    return 0;
}

static void forge_boxes(mlrt_tree *tree, enum forged_thing thing)
{
    uint32_t *inner = find_slot(tree, 0, 0), *next_inner = find_slot(tree, 0, 1), *leaf = find_slot(tree, 1, 0);
    uint32_t *next_leaf = find_slot(tree, 1, 1);
    struct mlrt_bvh_node *box = &tree->bvh.nodes[1];
    while (box->child[MLRT_BVH_WIDTH - 1] != 0) box++;
    assert_true(box < tree->bvh.nodes + tree->bvh.node_count);
    uint32_t filled = 0;
    while (box->child[filled]) filled++;
    const uint32_t first = tree->bvh.numbers[0], shared = find_shared_place(tree);
    switch ((int)thing) {
    case BOX_CYCLE:
        *next_inner = *inner;
        break;
    case BOX_CHILD_TWICE:
        box->child[0] = *inner;
        break;
    case BOX_CHILD_FAR:
        *next_inner = (tree->bvh.node_count + 7) << 3;
        break;
    case BOX_QUADS_FAR:
        *leaf = tree->bvh.quad_count << 3 | 4;
        break;
    case BOX_QUADS_TWICE:
        *next_leaf = *leaf;
        break;
    case BOX_QUADS_MANY:
        *leaf = (*leaf & ~7u) | 7;
        break;
    case BOX_NO_CHILDREN:
        box->child[0] = 0;
        break;
    case BOX_GAP:
        tree->bvh.nodes[0].child[1] = 0;
        break;
    case BOX_FULL_EMPTY_SLOT:
        box->lo[1][filled] = 0;
        break;
    case BOX_NAN_LO:
        box->lo[0][0] = NAN;
        break;
    case BOX_NAN_HI:
        box->hi[2][filled - 1] = NAN;
        break;
    case BOX_INFINITE:
        box->hi[2][0] = INFINITY;
        break;
    case BOX_INSIDE_OUT:
        box->hi[2][0] = next_float(box->lo[2][0], -1);
        break;
    case BOX_BEYOND_BOUNDS:
        box->lo[2][0] = next_float(tree->bounds.lo[2], -1);
        break;
    case BOX_NAN_EMPTY_SLOT:
        box->hi[1][filled] = NAN;
        break;
    case NUMBER_FAR:
        tree->bvh.numbers[0] = tree->triangle_count;
        break;
    case NUMBER_TWICE:
        tree->bvh.numbers[1] = tree->bvh.numbers[0];
        break;
    case NUMBER_NONE_FIRST:
        tree->bvh.numbers[0] = MLRT_NONE;
        break;
    case NUMBER_BEHIND_NONE:
        tree->bvh.numbers[1] = MLRT_NONE;
        break;
    case CORNER:
        tree->bvh.corners[9 * shared] = next_float(tree->bvh.corners[9 * shared], 1);
        break;
    case CORNER_OF_NOBODY:
        for (uint32_t i = 0; i < 4 * tree->bvh.quad_count; i++) {
            if (tree->bvh.numbers[i] == MLRT_NONE) {
                tree->bvh.numbers[i] = 0;
                return;
            }
        }
        fail_msg("all places are full");
        break;
    case TRIANGLE_NAN:
    case TRIANGLE_NAN_UNCOUNTED:
        *coordinate_of(tree, first, 0) = NAN;
        tree->info.non_finite_count += thing == TRIANGLE_NAN;
        break;
    case TRIANGLE_FLAT:
    case TRIANGLE_FLAT_UNCOUNTED:
        for (uint32_t row = 0; row < 3; row++) *coordinate_of(tree, first, row) = *coordinate_of(tree, first, row + 3);
        tree->info.zero_area_count += thing == TRIANGLE_FLAT;
        break;
    case TRIANGLE_ELSEWHERE:
        *coordinate_of(tree, tree->bvh.numbers[shared], 0) += 0x1p-10f;
        break;
    }
}

static void forge_kdtree(mlrt_tree *tree, enum forged_thing thing)
{
    struct mlrt_node *node = find_node(tree, 0, 1), *end = find_node(tree, 1, 0), *next_end = find_node(tree, 1, 1);
    struct mlrt_triangle *first = &tree->triangles[tree->kdtree.references[end->u.offset]];
    switch ((int)thing) {
    case NODE_CYCLE:
        node->word = node->word & 3;
        break;
    case NODE_BACK:
        node->word = (1u << 2) | (node->word & 3);
        break;
    case NODE_FAR:
        node->word = (tree->kdtree.node_count << 2) | (node->word & 3);
        break;
    case NODE_CHILD_TWICE:
        find_node(tree, 0, 2)->word = node->word;
        break;
    case NODE_PLANE_NAN:
        node->u.split = NAN;
        break;
    case NODE_PLANE_INFINITE:
        node->u.split = -INFINITY;
        break;
    case NODE_PLANE_OUTSIDE:
        node->u.split = next_float(tree->bounds.hi[mlrt_node_axis(node)], 1);
        break;
    case NODE_LEAF_FAR:
        end->u.offset = tree->kdtree.reference_count;
        break;
    case NODE_LEAF_MANY:
        end->word |= 0x10000000u;
        break;
    case NODE_LEAF_TWICE:
        *next_end = *end;
        break;
    case NODE_LEAF_EARLY:
        node->word = 3;
        break;
    case ENTRY_FAR:
        tree->kdtree.references[tree->kdtree.reference_count - 1] = tree->triangle_count;
        break;
    case ENTRY_TWICE:
        tree->kdtree.references[end->u.offset + 1] = tree->kdtree.references[end->u.offset];
        break;
    case ENTRY_NONE:
        tree->kdtree.references[0] = MLRT_NONE;
        break;
    case TRIANGLE_NAN:
    case TRIANGLE_NAN_UNCOUNTED:
        first->v[0][0] = NAN;
        tree->info.non_finite_count += thing == TRIANGLE_NAN;
        break;
    case TRIANGLE_FLAT:
    case TRIANGLE_FLAT_UNCOUNTED:
        memcpy(first->v[0], first->v[1], sizeof first->v[0]);
        tree->info.zero_area_count += thing == TRIANGLE_FLAT;
        break;
    }
}

static void forge(mlrt_tree *tree, enum forged_thing thing)
{
    switch ((int)thing) {
    case MESH_START:
        tree->meshes.first[0] = 1;
        break;
    case MESH_BACK:
        tree->meshes.first[1] = tree->meshes.first[2] + 1;
        break;
    case MESH_END:
        tree->meshes.first[tree->meshes.count]--;
        break;
    case MESH_ID_TWICE:
        tree->meshes.ids[0] = tree->meshes.ids[1];
        break;
    case MESH_ID_NONE:
        tree->meshes.ids[2] = MLRT_NONE;
        break;
    case MESH_POSITION:
        tree->meshes.by_id[0] = tree->meshes.count;
        break;
    case MESH_POSITION_TWICE:
        tree->meshes.by_id[1] = tree->meshes.by_id[0];
        break;
    case BOUNDS_LARGER:
        tree->info.bounds_max[0] = next_float(tree->info.bounds_max[0], 1);
        break;
    case BOUNDS_NAN:
        tree->info.bounds_min[1] = NAN;
        break;
    default:
        if (tree->structure == &mlrt_structure_bvh) {
            forge_boxes(tree, thing);
        } else {
            forge_kdtree(tree, thing);
        }
        break;
    }
}

/* Five meshes, the last of `more` triangles. */
static mlrt_tree *tree_of_meshes(size_t more, uint32_t structure)
{
    struct random random = {21};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, 1, 0.4f);
    mlrt_mesh meshes[MESH_COUNT];
    list_meshes(&soup, meshes);
    soup_add_random(&soup, &random, more, 1, 0.1f);
    for (int i = 0; i < MESH_COUNT; i++) {
        if (meshes[i].vertex_count) meshes[i].vertices = soup.corners + 9 * (i == 2 ? 10 : i == 3 ? 25 : 0);
    }
    meshes[4].vertices = soup.corners + 9 * 40;
    meshes[4].vertex_count = 3 * more;
    meshes[4].triangle_count = more;
    mlrt_tree *tree = build_structure(meshes, MESH_COUNT, structure);
    free_soup(&soup);
    return tree;
}

static int has_room(const mlrt_tree *tree)
{
    for (uint32_t i = 1; i < tree->bvh.node_count; i++) {
        if (tree->bvh.nodes[i].child[MLRT_BVH_WIDTH - 1] == 0) return 1;
    }
    return 0;
}

static int has_empty_place(const mlrt_tree *tree)
{
    for (uint32_t i = 0; i < 4 * tree->bvh.quad_count; i++) {
        if (tree->bvh.numbers[i] == MLRT_NONE) return 1;
    }
    return 0;
}

static void test_forged_trees_are_refused(void **state)
{
    const uint32_t structure = structure_given(state);
    const int is_bvh = structure == MLRT_STRUCTURE_BVH;
    mlrt_tree *tree = tree_of_meshes(600, structure);
    for (size_t more = 601; is_bvh && (!has_room(tree) || !has_empty_place(tree) || tree->bvh.numbers[2] == MLRT_NONE);
         more++) {
        mlrt_destroy_tree(tree);
        tree = tree_of_meshes(more, structure);
    }
    struct file file = save(tree);
    mlrt_destroy_tree(tree);
    for (int thing = 0; thing < THING_COUNT; thing++) {
        const uint32_t needed = structure_of((enum forged_thing)thing);
        if (needed != 0 && needed != structure) continue;
        tree = load(file.data, file.size, 0);
        assert_true(is_accepted(tree));
        forge(tree, (enum forged_thing)thing);
        if (is_accepted(tree)) fail_msg("forgery %d was not refused", thing);
        mlrt_destroy_tree(tree);
    }
    free_file(&file);
}

static uint32_t draw_value(struct random *random, uint32_t word)
{
    static const uint32_t values[] = {0,           1,           0xFFFFFFFFu, 0x7FFFFFFFu, 0x80000000u, 0x7FC00000u,
                                      0x7F800000u, 0xFF800000u, 0x7F7FFFFFu, 0x3F800000u, 0x00000001u, 0x5D800000u};
    const uint32_t choice = draw_below(random, 8);
    if (choice == 0) return values[draw_below(random, sizeof values / sizeof *values)];
    if (choice == 1) return draw_bits(random);
    if (choice == 2) return word + 1;
    if (choice == 3) return word - 1;
    if (choice == 4) return word + (8u << draw_below(random, 4));
    if (choice == 5) return word - (8u << draw_below(random, 4));
    return word ^ 1u << draw_below(random, 32);
}

/* A word of some section, another word instead, or the words of another place. */
static void mutate_words(struct random *random, struct file *file)
{
    const size_t table = FILE_SECTIONS + 16 * (size_t)draw_below(random, FILE_SECTION_COUNT);
    const uint64_t offset = number_at(file, table), words = number_at(file, table + 8) / 4;
    if (words == 0) return;
    const size_t place = offset + 4 * (size_t)draw_below(random, (uint32_t)words);
    const size_t other = offset + 4 * (size_t)draw_below(random, (uint32_t)words);
    if (draw_below(random, 4)) {
        put_word(file, place, draw_value(random, word_at(file, place)));
    } else {
        put_word(file, place, word_at(file, other));
    }
}

static float draw_between(struct random *random, float lo, float hi)
{
    const float value = draw_range(random, lo, hi);
    return draw_below(random, 4) == 0 ? lo : value < lo ? lo : value > hi ? hi : value;
}

/* Changes what no check can tell to be wrong: boxes, planes, which triangles leaves name, masks, ids. */
static void mislead(struct random *random, mlrt_tree *tree)
{
    static const uint32_t of_boxes[3] = {0, 1, 5}, of_kdtrees[4] = {2, 3, 4, 5};
    const int is_bvh = tree->structure == &mlrt_structure_bvh;
    const struct mlrt_bvh *bvh = &tree->bvh;
    const uint32_t i = draw_below(random, 1u << 30);
    const int k = (int)draw_below(random, 3);
    switch (is_bvh ? of_boxes[draw_below(random, 3)] : of_kdtrees[draw_below(random, 4)]) {
    case 0: {
        struct mlrt_bvh_node *node = &bvh->nodes[i % bvh->node_count];
        const uint32_t slot = draw_below(random, MLRT_BVH_WIDTH);
        if (node->child[slot] == 0) break;
        node->lo[k][slot] = draw_between(random, tree->bounds.lo[k], tree->bounds.hi[k]);
        node->hi[k][slot] = draw_between(random, node->lo[k][slot], tree->bounds.hi[k]);
        break;
    }
    case 1: {
        uint32_t *child = find_slot(tree, 1, i % info_of(tree).triangle_count % 3);
        const uint32_t places = 4 * mlrt_bvh_quad_count(*child), place = draw_below(random, places);
        uint32_t *numbers = bvh->numbers + 4 * mlrt_bvh_offset(*child), number = i % tree->triangle_count;
        if (numbers[place] == MLRT_NONE) break;
        numbers[place] = number;
        for (uint32_t row = 0; row < 9; row++) {
            bvh->corners[36 * mlrt_bvh_offset(*child) + places * row + place] = *coordinate_of(tree, number, row);
        }
        break;
    }
    case 2: {
        struct mlrt_node *node = &tree->kdtree.nodes[i % tree->kdtree.node_count];
        if (mlrt_node_is_leaf(node)) break;
        node->u.split =
            draw_between(random, tree->bounds.lo[mlrt_node_axis(node)], tree->bounds.hi[mlrt_node_axis(node)]);
        break;
    }
    case 3: {
        struct mlrt_node *node = &tree->kdtree.nodes[i % tree->kdtree.node_count];
        if (!mlrt_node_is_leaf(node)) node->word = (node->word & ~3u) | (uint32_t)k;
        break;
    }
    case 4:
        tree->kdtree.references[i % tree->kdtree.reference_count] += draw_below(random, 3) - 1;
        break;
    case 5:
        tree->masks[i % tree->triangle_count] = draw_bits(random);
        break;
    }
}

/* FORGERIES=10 in the environment tries ten times as many. */
static size_t forgery_count(size_t count)
{
    const char *times = getenv("FORGERIES");
    return scaled(count) * (times ? (size_t)strtoul(times, NULL, 10) : 1);
}

static void test_mutations_of_files_do_no_harm(void **state)
{
    const uint32_t structure = structure_given(state);
    mlrt_tree *trees[3] = {small_tree(30, structure), tree_of_meshes(600, structure), small_tree(40, structure)};
    size_t accepted = 0, count = forgery_count(4500);
    for (int t = 0; t < 3; t++) {
        struct file file = save(trees[t]), changed = copy_file(&file);
        for (uint64_t seed = 1; seed <= count / 3; seed++) {
            struct random random = {seed};
            memcpy(changed.data, file.data, file.size);
            for (uint32_t n = draw_below(&random, 3) + 1; n > 0; n--) mutate_words(&random, &changed);
            repair_hash(changed.data, changed.size);
            accepted += (size_t)load_and_exercise(changed.data, changed.size, (int)draw_below(&random, 2), seed);
        }
        free_file(&file);
        free_file(&changed);
        mlrt_destroy_tree(trees[t]);
    }
    assert_true(accepted > count / 100 && accepted < count);
}

static void test_misleading_trees_do_no_harm(void **state)
{
    static const uint32_t masks[MESH_COUNT] = {1, 2, 4, 8, 16};
    mlrt_tree *tree = tree_of_meshes(600, structure_given(state));
    give_masks(tree, masks);
    struct file file = save(tree);
    size_t accepted = 0, count = forgery_count(750);
    for (uint64_t seed = 1; seed <= count; seed++) {
        struct random random = {seed};
        mlrt_tree *forged = load(file.data, file.size, 0);
        for (uint32_t n = draw_below(&random, 6) + 1; n > 0; n--) mislead(&random, forged);
        struct file changed = save(forged);
        accepted += (size_t)load_and_exercise(changed.data, changed.size, (int)draw_below(&random, 2), seed);
        free_file(&changed);
        mlrt_destroy_tree(forged);
    }
    assert_true(accepted > count / 4 && accepted < count);
    free_file(&file);
    mlrt_destroy_tree(tree);
}

/* A kd-tree whose lower children go `depth` deep, and nodes behind it that have no parent. */
static int deep_kdtree_is_accepted(uint32_t depth, uint32_t orphans)
{
    mlrt_tree *tree = small_tree(1, MLRT_STRUCTURE_KDTREE);
    struct mlrt_node *const kept = tree->kdtree.nodes, nodes[2 * 80 + 1] = {{{0}, 0}};
    struct mlrt_node *chain = (struct mlrt_node *)(void *)nodes;
    const uint32_t kept_count = tree->kdtree.node_count, reference_count = tree->kdtree.reference_count;
    for (uint32_t i = 0; i < depth; i++) {
        const uint32_t at = i == 0 ? 0 : 2 * i - 1;
        chain[at].u.split = tree->bounds.hi[0];
        chain[at].word = (2 * i + 1) << 2;
        chain[2 * i + 2].word = 3;
    }
    struct mlrt_node *deepest = &chain[depth == 0 ? 0 : 2 * depth - 1];
    deepest->u.offset = 0;
    deepest->word = (1u << 2) | 3;
    for (uint32_t i = 0; i < depth; i++) chain[2 * i + 2].u.offset = 1;
    tree->kdtree.nodes = chain;
    tree->kdtree.node_count = 2 * depth + 1 + orphans;
    tree->kdtree.reference_count = 1;
    assert_int_equal(tree->kdtree.references[0], 0);
    const int accepted = is_accepted(tree);
    tree->kdtree.nodes = kept;
    tree->kdtree.node_count = kept_count;
    tree->kdtree.reference_count = reference_count;
    mlrt_destroy_tree(tree);
    return accepted;
}

static void test_deep_kdtrees_are_refused(void **state)
{
    (void)state;
    assert_true(deep_kdtree_is_accepted(0, 0));
    assert_true(deep_kdtree_is_accepted(1, 0));
    assert_true(deep_kdtree_is_accepted(MLRT_DEPTH_LIMIT, 0));
    assert_false(deep_kdtree_is_accepted(MLRT_DEPTH_LIMIT + 1, 0));
    assert_false(deep_kdtree_is_accepted(MLRT_DEPTH_LIMIT + 15, 0));
    assert_false(deep_kdtree_is_accepted(10, 1));
    assert_false(deep_kdtree_is_accepted(10, 2));
}

/* Nodes with 16 children that are all one node, but for the last of `depth`: a tree of 15 leaves and a node each. */
static int deep_boxes_are_accepted(uint32_t depth, uint32_t places)
{
    enum { TRIANGLES = 16 * (MLRT_BVH_DEPTH_LIMIT + 1) };
    struct random random = {23};
    struct soup soup = {0};
    soup_add_random(&soup, &random, TRIANGLES, 1, 0.2f);
    mlrt_tree *tree = tree_of_soup(&soup, MLRT_STRUCTURE_BVH);
    const struct mlrt_bvh kept = tree->bvh;
    struct file nodes = make_file(depth * sizeof(struct mlrt_bvh_node));
    struct mlrt_bvh *bvh = &tree->bvh;
    put_in_order(tree);
    bvh->nodes = (struct mlrt_bvh_node *)(void *)nodes.data;
    bvh->node_count = depth;
    bvh->quad_count = 0;
    bvh->corners = allocate_or_fail(36 * TRIANGLES + 16, sizeof *bvh->corners);
    bvh->numbers = allocate_or_fail(4 * TRIANGLES + 16, sizeof *bvh->numbers);
    for (uint32_t i = 0; i < 36 * TRIANGLES + 16; i++) bvh->corners[i] = NAN;
    memset(bvh->numbers, 0xFF, (4 * TRIANGLES + 16) * sizeof *bvh->numbers);
    // Depth first, the slot of the node is the first: leaves of the deepest come first.
    for (uint32_t i = depth; i-- > 0;) {
        struct mlrt_bvh_node *node = &bvh->nodes[i];
        for (uint32_t slot = 0; slot < MLRT_BVH_WIDTH; slot++) {
            const int filled = slot < places;
            for (int k = 0; k < 3; k++) {
                node->lo[k][slot] = filled ? tree->bounds.lo[k] : INFINITY;
                node->hi[k][slot] = filled ? tree->bounds.hi[k] : -INFINITY;
            }
            node->child[slot] = 0;
            if (!filled) continue;
            if (slot == 0 && i + 1 < depth) {
                node->child[slot] = (i + 1) << 3;
                continue;
            }
            const uint32_t quad = bvh->quad_count++, number = quad % TRIANGLES;
            node->child[slot] = quad << 3 | 1;
            bvh->numbers[4 * quad] = number;
            for (uint32_t row = 0; row < 9; row++) {
                bvh->corners[36 * quad + 4 * row] = tree->triangles[number].v[row / 3][row % 3];
            }
        }
    }
    bvh->leaf_quad_count = bvh->quad_count;
    const int accepted = is_accepted(tree);
    free(bvh->corners);
    free(bvh->numbers);
    free_file(&nodes);
    put_back(tree, &kept);
    mlrt_destroy_tree(tree);
    return accepted;
}

/* Stacks that are as full as they may be. */
static void test_deep_boxes_are_refused(void **state)
{
    (void)state;
    assert_true(deep_boxes_are_accepted(1, 16));
    assert_true(deep_boxes_are_accepted(MLRT_BVH_DEPTH_LIMIT, 1));
    assert_true(deep_boxes_are_accepted(MLRT_BVH_DEPTH_LIMIT, 16));
    assert_false(deep_boxes_are_accepted(MLRT_BVH_DEPTH_LIMIT + 1, 1));
    assert_false(deep_boxes_are_accepted(MLRT_BVH_DEPTH_LIMIT + 1, 16));
}

/* One leaf of so many quads, all of them full. */
static int large_leaf_is_accepted(uint32_t quads)
{
    struct random random = {24};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 4 * quads, 1, 0.2f);
    mlrt_tree *tree = tree_of_soup(&soup, MLRT_STRUCTURE_BVH);
    const struct mlrt_bvh kept = tree->bvh;
    struct file nodes = make_file(sizeof(struct mlrt_bvh_node));
    struct mlrt_bvh_node *root = (struct mlrt_bvh_node *)(void *)nodes.data;
    float corners[36 * 7 + 16] = {0};
    uint32_t numbers[4 * 7 + 16] = {0};
    put_in_order(tree);
    for (int k = 0; k < 3; k++) {
        for (int slot = 0; slot < MLRT_BVH_WIDTH; slot++) {
            root->lo[k][slot] = slot == 0 ? tree->bounds.lo[k] : INFINITY;
            root->hi[k][slot] = slot == 0 ? tree->bounds.hi[k] : -INFINITY;
            root->child[slot] = slot == 0 ? quads : 0;
        }
    }
    for (uint32_t i = 0; i < 4 * quads; i++) {
        numbers[i] = i;
        for (uint32_t row = 0; row < 9; row++) corners[4 * quads * row + i] = tree->triangles[i].v[row / 3][row % 3];
    }
    tree->bvh.nodes = root;
    tree->bvh.node_count = 1;
    tree->bvh.quad_count = tree->bvh.leaf_quad_count = quads;
    tree->bvh.corners = corners;
    tree->bvh.numbers = numbers;
    const int accepted = is_accepted(tree);
    free_file(&nodes);
    put_back(tree, &kept);
    mlrt_destroy_tree(tree);
    return accepted;
}

static void test_large_leaves_are_refused(void **state)
{
    (void)state;
    for (uint32_t quads = 1; quads <= 7; quads++) assert_int_equal(large_leaf_is_accepted(quads), quads <= 4);
}

/* Each triangle in turn made one that is to be left out, counted as such, in a tree of one structure. */
static void test_leaves_may_not_name_what_was_left_out(void **state)
{
    (void)state;
    for (uint32_t structure = MLRT_STRUCTURE_KDTREE; structure <= MLRT_STRUCTURE_BVH; structure++) {
        for (uint32_t number = 0; number < 2 * 40; number++) {
            mlrt_tree *tree = small_tree(40, structure);
            const uint32_t triangle = number / 2;
            if (number % 2) {
                *coordinate_of(tree, triangle, 0) = NAN;
                tree->info.non_finite_count++;
            } else {
                for (uint32_t i = 0; i < 3; i++)
                    *coordinate_of(tree, triangle, i) = *coordinate_of(tree, triangle, i + 3);
                tree->info.zero_area_count++;
            }
            for (uint32_t quad = 0; quad < tree->bvh.quad_count;) {
                uint32_t quads = 0;
                for (uint32_t i = 0; i < 16 * tree->bvh.node_count; i++) {
                    const uint32_t child = tree->bvh.nodes[i / 16].child[i % 16];
                    if (mlrt_bvh_quad_count(child) && mlrt_bvh_offset(child) == quad) {
                        quads = mlrt_bvh_quad_count(child);
                    }
                }
                for (uint32_t place = 0; place < 4 * quads; place++) {
                    for (uint32_t row = 0; row < 9 && tree->bvh.numbers[4 * quad + place] == number / 2; row++) {
                        tree->bvh.corners[36 * quad + 4 * quads * row + place] = *coordinate_of(tree, triangle, row);
                    }
                }
                quad += quads;
            }
            assert_false(is_accepted(tree));
            mlrt_destroy_tree(tree);
        }
    }
}

/* Puts a word into section `section` of a file, repairs the hash, and puts the word back after loading. */
static int is_accepted_with(struct file *file, uint32_t section, size_t i, uint32_t word)
{
    const size_t offset = (size_t)number_at(file, FILE_SECTIONS + 16 * (size_t)section) + 4 * i;
    const uint32_t kept = word_at(file, offset);
    put_word(file, offset, word);
    repair_hash(file->data, file->size);
    const int accepted = load_and_exercise(file->data, file->size, 0, 7);
    assert_int_equal(load_and_exercise(file->data, file->size, 1, 8), accepted);
    put_word(file, offset, kept);
    return accepted;
}

/* Places of triangles in leaves and, from 40 on, of triangles that are left out: those are in quads of their own. */
static void test_forged_places_are_refused(void **state)
{
    enum { IN_LEAVES = 40, COUNT = 46, CORNERS = 8, NUMBERS = 9, PLACES = 10 };
    (void)state;
    struct random random = {25};
    struct soup soup = {0};
    soup_add_random(&soup, &random, COUNT, 1, 0.4f);
    for (int i = IN_LEAVES; i < COUNT; i++) soup.corners[9 * i] = NAN;
    mlrt_tree *tree = tree_of_soup(&soup, MLRT_STRUCTURE_BVH);
    const struct mlrt_bvh *bvh = &tree->bvh;
    assert_int_equal(bvh->quad_count, bvh->leaf_quad_count + 2);
    struct file file = save(tree);
    const uint32_t given = bvh->leaf_quad_count, *places = bvh->places;
    const uint32_t far[] = {0xFFFFFFFFu, mlrt_pack_place(bvh->quad_count, 1, 0), mlrt_pack_place(given + 1, 2, 0),
                            mlrt_pack_place(given, 1, 4), mlrt_pack_place(given - 1, 4, 0)};
    for (uint32_t number = 0; number < COUNT; number++) {
        assert_true(is_accepted_with(&file, PLACES, number, places[number]));
        for (size_t i = 0; i < sizeof far / sizeof *far; i++)
            assert_false(is_accepted_with(&file, PLACES, number, far[i]));
        for (uint32_t other = 0; other < COUNT; other++) {
            if (other != number) assert_false(is_accepted_with(&file, PLACES, number, places[other]));
        }
        for (uint32_t bit = 0; bit < 2; bit++)
            assert_false(is_accepted_with(&file, PLACES, number, places[number] ^ 1u << bit));
    }
    for (size_t i = 0; i < COUNT - IN_LEAVES; i++) {
        const size_t place = 4 * (size_t)given + i;
        assert_int_equal(bvh->numbers[place], IN_LEAVES + i);
        assert_false(is_accepted_with(&file, NUMBERS, place, COUNT));
        assert_false(is_accepted_with(&file, NUMBERS, place, MLRT_NONE));
        assert_false(is_accepted_with(&file, NUMBERS, place, 0));
        assert_false(is_accepted_with(&file, CORNERS, 36 * (size_t)given + 36 * (i / 4) + i % 4, 0));
    }
    assert_false(is_accepted_with(&file, NUMBERS, 4 * (size_t)given + 7, 0));
    free_file(&file);
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

/* A tree may have its triangles in order instead of places: as trees have that are too large for places. */
static void test_trees_in_order_come_back(void **state)
{
    (void)state;
    mlrt_tree *tree = small_tree(300, MLRT_STRUCTURE_BVH), *same = small_tree(300, MLRT_STRUCTURE_BVH);
    const struct mlrt_bvh kept = tree->bvh;
    put_in_order(tree);
    struct file file = save(tree);
    mlrt_tree *loaded = load(file.data, file.size, 0);
    assert_non_null(loaded->triangles);
    assert_null(loaded->bvh.places);
    assert_same_tree(tree, &file, loaded);
    assert_same_answers(same, loaded);
    loaded->triangles[7].v[1][1] += 0x1p-12f;
    assert_false(is_accepted(loaded));
    mlrt_destroy_tree(loaded);
    free_file(&file);
    put_back(tree, &kept);
    mlrt_destroy_tree(tree);
    mlrt_destroy_tree(same);
}

/* Then a triangle that is hit would be one of no mesh. */
static void test_triangles_need_meshes(void **state)
{
    (void)state;
    for (uint32_t structure = MLRT_STRUCTURE_KDTREE; structure <= MLRT_STRUCTURE_BVH; structure++) {
        mlrt_tree *tree = small_tree(40, structure);
        const uint32_t mesh_count = tree->meshes.count;
        assert_true(is_accepted(tree));
        tree->meshes.count = 0;
        tree->meshes.first[0] = tree->triangle_count;
        assert_false(is_accepted(tree));
        tree->meshes.count = mesh_count;
        mlrt_destroy_tree(tree);
    }
}

/* Files for fuzz_load.c to start from, where FUZZ_FILES says. */
static void write_fuzz_files(const char *folder)
{
    mlrt_tree *trees[4] = {small_tree(1, MLRT_STRUCTURE_BVH), small_tree(40, MLRT_STRUCTURE_BVH),
                           small_tree(1, MLRT_STRUCTURE_KDTREE), small_tree(40, MLRT_STRUCTURE_KDTREE)};
    for (int i = 0; i < 4; i++) {
        char name[1000];
        snprintf(name, sizeof name, "%s/%d", folder, i);
        struct file file = save(trees[i]);
        FILE *stream = fopen(name, "wb");
        if (stream) {
            fwrite(file.data, 1, file.size, stream);
            fclose(stream);
        }
        free_file(&file);
        mlrt_destroy_tree(trees[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_empty_trees_come_back),
        cmocka_unit_test(test_one_triangle_comes_back),
        cmocka_unit_test(test_soups_come_back),
        cmocka_unit_test(test_shapes_come_back),
        cmocka_unit_test(test_huge_and_tiny_coordinates_come_back),
        cmocka_unit_test(test_left_out_triangles_come_back),
        cmocka_unit_test(test_meshes_come_back),
        cmocka_unit_test(test_masks_come_back),
        cmocka_unit_test(test_loaded_trees_answer_like_built_ones),
        cmocka_unit_test(test_a_scene_comes_back),
        OF_BOTH(test_a_mapped_file_will_do),
        OF_BOTH(test_equal_trees_are_equal_files),
        OF_BOTH(test_a_buffer_that_is_too_small_stays_as_it_is),
        OF_BOTH(test_saving_works_at_any_address_and_in_larger_buffers),
        OF_BOTH(test_arguments_are_checked),
        OF_BOTH(test_messages_say_what_is_wrong),
        OF_BOTH(test_running_out_of_memory_leaves_nothing),
        OF_BOTH(test_a_host_whose_memory_ends_gets_all_of_it_back),
        OF_BOTH(test_the_floating_point_environment_does_not_matter),
        cmocka_unit_test(test_the_geometry_hash_is_that_of_the_file),
        cmocka_unit_test(test_the_geometry_hash_knows_masks),
        cmocka_unit_test(test_the_geometry_hash_does_not_depend_on_layout),
        cmocka_unit_test(test_the_geometry_hash_checks_meshes),
        OF_BOTH(test_every_shorter_file_is_refused),
        OF_BOTH(test_every_changed_byte_is_noticed),
        OF_BOTH(test_other_orders_and_versions_are_refused),
        OF_BOTH(test_forged_headers_are_refused),
        OF_BOTH(test_forged_trees_are_refused),
        OF_BOTH(test_mutations_of_files_do_no_harm),
        OF_BOTH(test_misleading_trees_do_no_harm),
        cmocka_unit_test(test_deep_kdtrees_are_refused),
        cmocka_unit_test(test_deep_boxes_are_refused),
        cmocka_unit_test(test_large_leaves_are_refused),
        cmocka_unit_test(test_triangles_need_meshes),
        cmocka_unit_test(test_forged_places_are_refused),
        cmocka_unit_test(test_trees_in_order_come_back),
        cmocka_unit_test(test_leaves_may_not_name_what_was_left_out),
    };
    if (getenv("FUZZ_FILES")) {
        write_fuzz_files(getenv("FUZZ_FILES"));
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
