/* SPDX-License-Identifier: MIT */
/*
 * mlrt_last_message: each thread has its own, only calls that fail change it, and each check leaves a text of its own.
 * docs/errors.md has all of them: WRITE_ERRORS=1 build/tests/test_messages writes its table anew. One has no row, since
 * no tree is so large where addresses have 64 bits: that a file is more than a process can address (api/save.c).
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bvh/build.h"
#include "bvh/node.h"
#include "forged_files.h"
#include "mlrta/kdtree.h"
#include "run/dispatch.h"
#include "scene/tree.h"
#include "support.h"

static const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};

static mlrt_tree *some_tree(void)
{
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    return tree;
}

/* A call that fails and one that succeeds, in a thread that has made no call: NULL, or what was wrong. */
static void *use_a_new_thread(void *tree)
{
    char first[300];
    mlrt_tree_info info = {.struct_size = sizeof info};
    if (mlrt_last_message()[0]) return "not empty at first";
    if (mlrt_get_tree_info(tree, NULL) != MLRT_ERROR_ARGUMENT) return "no error";
    if (!mlrt_last_message()[0]) return "empty after an error";
    strcpy(first, mlrt_last_message());
    if (mlrt_get_tree_info(tree, &info) != MLRT_OK) return "an error";
    if (strcmp(mlrt_last_message(), first) != 0) return "changed by a call that succeeds";
    info.struct_size = 3;
    if (mlrt_get_tree_info(tree, &info) != MLRT_ERROR_STRUCT_SIZE) return "not the error of the size";
    if (strcmp(mlrt_last_message(), first) == 0) return "not changed by another error";
    return NULL;
}

#define THREAD_COUNT 8

static void each_thread_has_its_own(void **state)
{
    (void)state;
    pthread_t threads[THREAD_COUNT];
    mlrt_tree *tree = some_tree();
    char before[300];
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, NULL), MLRT_ERROR_ARGUMENT);
    strcpy(before, mlrt_last_message());
    for (int i = 0; i < THREAD_COUNT; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, use_a_new_thread, tree), 0);
    for (int i = 0; i < THREAD_COUNT; i++) {
        void *wrong = "not joined";
        assert_int_equal(pthread_join(threads[i], &wrong), 0);
        if (wrong) fail_msg("a new thread's message: %s", (const char *)wrong);
    }
    assert_string_equal(mlrt_last_message(), before);
    mlrt_destroy_tree(tree);
}

/* ---- every check ---- */

/* What the calls of a check are made with: all is right until a check breaks one field. */
static struct setting {
    mlrt_tree *tree, *kdtree, *made;
    mlrt_mesh meshes[2];
    mlrt_tree_options build;
    mlrt_kdtree_options kdbuild;
    mlrt_load_options load;
    mlrt_pool_options pool_options;
    mlrt_pool *pool;
    mlrt_host host;
    mlrt_counters counters;
    mlrt_trace_options options;
    mlrt_rays rays;
    mlrt_hits hits;
    mlrt_hit_lists lists;
    mlrt_ray ray, shadow;
    mlrt_hit hit;
    mlrt_camera camera;
    mlrt_light light, lights[2];
    mlrt_points points;
    mlrt_array vectors, dark;
    mlrt_tree_info info;
    mlrt_memory_estimate estimate;
    int32_t faces;
    uint64_t hash;
    size_t size;
    float point[3];
} now, right;

static const float large[9] = {0, 0, 0, 2, 0, 0, 0, 2, 0};
static float numbers[64], flat[9] = {0, 0, 0, 1, 1, 1, 2, 2, 2};
static unsigned char bytes[8192];
static char listing[1 << 15];
static int is_complete; /* the listing has all checks */

/* ---- what is pretended ---- */

/*
 * Functions that the linker puts in place of the library's and the system's (--wrap in the Makefile): they pretend what
 * needs a special machine, or a tree of billions of triangles.
 */
static enum { NOTHING, NO_MORE_THREADS, NO_AVX512, MANY_QUADS } pretended;

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*function)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*function)(void *), void *data);
const struct mlrt_kernels *__real_mlrt_select_kernels(const struct mlrt_structure *structure, int32_t isa,
                                                      int32_t method, int counting);
const struct mlrt_kernels *__wrap_mlrt_select_kernels(const struct mlrt_structure *structure, int32_t isa,
                                                      int32_t method, int counting);
int32_t __real_mlrt_build_binary(struct mlrt_bvh_build *build);
int32_t __wrap_mlrt_build_binary(struct mlrt_bvh_build *build);

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*function)(void *), void *data)
{
    static int started;
    if (pretended == NO_MORE_THREADS && started++ == 1) return EAGAIN;
    return __real_pthread_create(thread, attributes, function, data);
}

const struct mlrt_kernels *__wrap_mlrt_select_kernels(const struct mlrt_structure *structure, int32_t isa,
                                                      int32_t method, int counting)
{
    if (pretended == NO_AVX512 && isa == MLRT_ISA_AVX512) return NULL;
    return __real_mlrt_select_kernels(structure, isa, method, counting);
}

/* A hierarchy of one leaf pretends that this has 2^30 - 1 quads. */
int32_t __wrap_mlrt_build_binary(struct mlrt_bvh_build *build)
{
    const int32_t status = __real_mlrt_build_binary(build);
    if (pretended == MANY_QUADS) build->binary.nodes[0].count = UINT32_MAX - 3;
    return status;
}

/* ---- checks ---- */

/* Rows of docs/errors.md, in the order of their checks; each once. */
static void list_row(int32_t status, const char *text)
{
    static const char *const names[] = {"OK",        "ARGUMENT", "STRUCT_SIZE", "INDEX_RANGE", "OUT_OF_MEMORY",
                                        "TOO_LARGE", "CAMERA",   "UNSUPPORTED", "THREAD",      "CANCELLED",
                                        "DATA"};
    char row[300];
    snprintf(row, sizeof row, "| %s | %s |\n", text, names[status]);
    if (strstr(listing, row)) return;
    assert_true(strlen(listing) + strlen(row) < sizeof listing);
    strcat(listing, row);
}

static void expect(int32_t status, const char *text, int32_t got, int line)
{
    if (got != status || strcmp(mlrt_last_message(), text) != 0)
        fail_msg("line %d: %d '%s', not %d '%s'", line, (int)got, mlrt_last_message(), (int)status, text);
    assert_true(strlen(text) <= 255);
    list_row(status, text);
    now = right;
    pretended = NOTHING;
}

/* Breaks something, makes a call, and compares status and text. */
#define CHECK(change, call, status, text) ((void)(change), expect(MLRT_ERROR_##status, text, call, __LINE__))

#define BUILD                        mlrt_build_tree(now.meshes, 2, &now.build, &now.made)
#define BUILD_KD                     mlrt_build_kdtree(now.meshes, 2, &now.kdbuild, &now.made)
#define PACKET                       mlrt_trace_packet(now.tree, &now.rays, &now.options, &now.hits)
#define RAY                          mlrt_trace_ray(now.tree, &now.ray, &now.options, &now.hit)
#define ALL                          mlrt_trace_all_hits(now.tree, &now.rays, &now.options, &now.lists)
#define RENDER                       mlrt_render_tiles(now.tree, &now.camera, &now.options, &now.hits, NULL, NULL)
#define WRITE_RAYS                   mlrt_camera_rays(&now.camera, &now.vectors, NULL)
#define POINTS                       mlrt_occluded_points(now.tree, &now.points, &now.light, &now.options, &now.dark)
#define SHADOW                       mlrt_shadow_ray(now.tree, &now.ray, &now.hit, &now.light, &now.shadow, &now.faces)
#define POOL                         mlrt_create_pool_with_options(&now.pool_options, &now.pool)
#define LOAD(size)                   mlrt_load_tree(bytes, size, &now.load, &now.made)
#define OFFSET(triangle, u, v, side) mlrt_offset_point(now.tree, 0, triangle, u, v, side, now.point)

static void *enqueue_nothing(void *user, mlrt_task_function function, void *argument)
{
    (void)user;
    function(argument);
    return NULL;
}

static void finish_nothing(void *user, void *task)
{
    (void)user, (void)task;
}

static int32_t stop(void *user, double fraction)
{
    (void)user, (void)fraction;
    return 1;
}

static int32_t stop_tile(void *user, const mlrt_tile *tile)
{
    (void)user, (void)tile;
    return 1;
}

static void set_up(void)
{
    static const float eye[3] = {0, 0, 0};
    memset(&now, 0, sizeof now);
    now.tree = some_tree();
    now.meshes[0] =
        (mlrt_mesh){.struct_size = sizeof(mlrt_mesh), .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    now.meshes[1] = now.meshes[0];
    now.kdtree = build_structure(now.meshes, 1, MLRT_STRUCTURE_KDTREE);
    now.build.struct_size = sizeof now.build;
    now.kdbuild.struct_size = sizeof now.kdbuild;
    now.load.struct_size = sizeof now.load;
    now.pool_options.struct_size = sizeof now.pool_options;
    now.host.struct_size = sizeof now.host;
    now.counters.struct_size = sizeof now.counters;
    now.options.struct_size = sizeof now.options;
    now.rays =
        (mlrt_rays){.struct_size = sizeof now.rays, .count = 4, .origins = {numbers, 0}, .directions = {numbers, 0}};
    now.hits = (mlrt_hits){.struct_size = sizeof now.hits, .t = {numbers + 32, 0, 0}};
    now.lists = (mlrt_hit_lists){.struct_size = sizeof now.lists, .total = {numbers + 32, 0, 0}};
    now.ray = (mlrt_ray){.struct_size = sizeof now.ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    now.shadow.struct_size = sizeof now.shadow;
    now.hit.struct_size = sizeof now.hit;
    now.camera = look_at(eye, corners, 1, 2, 2);
    now.light = light_at(0, 0, -5);
    now.lights[0] = now.lights[1] = now.light;
    now.points = (mlrt_points){.struct_size = sizeof now.points, .count = 4, .positions = {numbers, 0}};
    now.dark.data = bytes;
    now.vectors.data = numbers;
    now.info.struct_size = sizeof now.info;
    now.estimate.struct_size = sizeof now.estimate;
    right = now;
}

static void check_null(void)
{
#define WITHOUT(name, call) CHECK(0, call, ARGUMENT, name ": NULL is not allowed")
    WITHOUT("tree", mlrt_build_tree(now.meshes, 2, NULL, NULL));
    WITHOUT("tree", mlrt_build_kdtree(now.meshes, 2, NULL, NULL));
    WITHOUT("tree", mlrt_trace_packet(NULL, &now.rays, NULL, &now.hits));
    WITHOUT("rays", mlrt_trace_packet(now.tree, NULL, NULL, &now.hits));
    WITHOUT("hits", mlrt_trace_packet(now.tree, &now.rays, NULL, NULL));
    WITHOUT("tree", mlrt_trace_ray(NULL, &now.ray, NULL, &now.hit));
    WITHOUT("ray", mlrt_trace_ray(now.tree, NULL, NULL, &now.hit));
    WITHOUT("hit", mlrt_trace_ray(now.tree, &now.ray, NULL, NULL));
    WITHOUT("tree", mlrt_trace_all_hits(NULL, &now.rays, NULL, &now.lists));
    WITHOUT("rays", mlrt_trace_all_hits(now.tree, NULL, NULL, &now.lists));
    WITHOUT("lists", mlrt_trace_all_hits(now.tree, &now.rays, NULL, NULL));
    WITHOUT("tree", mlrt_render_tiles(NULL, &now.camera, NULL, NULL, NULL, NULL));
    WITHOUT("camera", mlrt_render_tiles(now.tree, NULL, NULL, NULL, NULL, NULL));
    WITHOUT("camera", mlrt_camera_rays(NULL, NULL, NULL));
    WITHOUT("tree", mlrt_occluded_points(NULL, &now.points, &now.light, NULL, &now.dark));
    WITHOUT("points", mlrt_occluded_points(now.tree, NULL, &now.light, NULL, &now.dark));
    WITHOUT("light", mlrt_occluded_points(now.tree, &now.points, NULL, NULL, &now.dark));
    WITHOUT("occluded", mlrt_occluded_points(now.tree, &now.points, &now.light, NULL, NULL));
    WITHOUT("tree", mlrt_shadow_ray(NULL, &now.ray, &now.hit, &now.light, &now.shadow, &now.faces));
    WITHOUT("ray", mlrt_shadow_ray(now.tree, NULL, &now.hit, &now.light, &now.shadow, &now.faces));
    WITHOUT("hit", mlrt_shadow_ray(now.tree, &now.ray, NULL, &now.light, &now.shadow, &now.faces));
    WITHOUT("light", mlrt_shadow_ray(now.tree, &now.ray, &now.hit, NULL, &now.shadow, &now.faces));
    WITHOUT("shadow", mlrt_shadow_ray(now.tree, &now.ray, &now.hit, &now.light, NULL, &now.faces));
    WITHOUT("faces", mlrt_shadow_ray(now.tree, &now.ray, &now.hit, &now.light, &now.shadow, NULL));
    WITHOUT("tree", mlrt_offset_point(NULL, 0, 0, 0, 0, 1, now.point));
    WITHOUT("point", mlrt_offset_point(now.tree, 0, 0, 0, 0, 1, NULL));
    WITHOUT("tree", mlrt_get_tree_info(NULL, &now.info));
    WITHOUT("info", mlrt_get_tree_info(now.tree, NULL));
    WITHOUT("estimate", mlrt_estimate_tree(now.meshes, 2, NULL, NULL));
    WITHOUT("hash", mlrt_hash_geometry(now.meshes, 2, NULL));
    WITHOUT("tree", mlrt_save_tree(NULL, NULL, 0, &now.size));
    WITHOUT("size", mlrt_save_tree(now.tree, NULL, 0, NULL));
    WITHOUT("data", mlrt_load_tree(NULL, 0, NULL, &now.made));
    WITHOUT("tree", mlrt_load_tree(bytes, 0, NULL, NULL));
    WITHOUT("pool", mlrt_create_pool(1, NULL));
    WITHOUT("options", mlrt_create_pool_with_options(NULL, &now.pool));
    WITHOUT("pool", mlrt_create_pool_with_options(&now.pool_options, NULL));
    CHECK(now.dark.data = NULL, POINTS, ARGUMENT, "occluded.data: NULL is not allowed");
}

static void check_sizes(void)
{
    static struct {
        mlrt_rays rays;
        uint32_t more;
    } longer;
    char text[128];
    longer.rays = now.rays;
    longer.rays.struct_size = sizeof longer;
    ((unsigned char *)&longer)[sizeof now.rays + 1] = 1;
#define SIZE(field, type, last, call, path)                                                                            \
    snprintf(text, sizeof text, path ".struct_size: 13 is not a multiple of %u from %u to %u",                         \
             (unsigned)__alignof__(type), (unsigned)(offsetof(type, last) + sizeof now.field.last),                    \
             (unsigned)sizeof(type) + 256);                                                                            \
    CHECK(now.field.struct_size = 13, call, STRUCT_SIZE, text)
    SIZE(meshes[0], mlrt_mesh, mask, BUILD, "meshes[0]");
    SIZE(build, mlrt_tree_options, pool, BUILD, "options");
    SIZE(kdbuild, mlrt_kdtree_options, rules_off, BUILD_KD, "options");
    SIZE(load, mlrt_load_options, host, LOAD(9), "options");
    SIZE(pool_options, mlrt_pool_options, finish, POOL, "options");
    SIZE(options, mlrt_trace_options, counters, PACKET, "options");
    now.options.counters = &now.counters;
    SIZE(counters, mlrt_counters, exact_order_count, PACKET, "options.counters");
    now.options.host = &now.host;
    SIZE(host, mlrt_host, progress, PACKET, "options.host");
    SIZE(rays, mlrt_rays, skip, PACKET, "rays");
    SIZE(hits, mlrt_hits, occluded, PACKET, "hits");
    SIZE(hits, mlrt_hits, occluded, RENDER, "frame");
    SIZE(lists, mlrt_hit_lists, crossing_total, ALL, "lists");
    SIZE(ray, mlrt_ray, skip_triangle, RAY, "ray");
    SIZE(hit, mlrt_hit, occluded, RAY, "hit");
    SIZE(shadow, mlrt_ray, skip_triangle, SHADOW, "shadow");
    SIZE(camera, mlrt_camera, t_max, RENDER, "camera");
    SIZE(light, mlrt_light, position, POINTS, "light");
    SIZE(points, mlrt_points, skip, POINTS, "points");
    SIZE(info, mlrt_tree_info, reserved, mlrt_get_tree_info(now.tree, &now.info), "info");
    SIZE(estimate, mlrt_memory_estimate, peak_memory_size, mlrt_estimate_tree(NULL, 0, NULL, &now.estimate),
         "estimate");
    CHECK(now.light.struct_size = 22, POINTS, STRUCT_SIZE,
          "light.struct_size: 22 is not a multiple of 4 from 20 to 276");
    CHECK(now.light.struct_size = 280, POINTS, STRUCT_SIZE,
          "light.struct_size: 280 is not a multiple of 4 from 20 to 276");
    CHECK((now.options.lights = now.lights, now.options.light_count = 2, now.lights[1].struct_size = 24), RENDER,
          STRUCT_SIZE, "options.lights[1].struct_size: 24 is not that of element 0, 20");
    snprintf(text, sizeof text, "rays: byte %u is not 0, but this version knows only %u bytes",
             (unsigned)sizeof now.rays + 1, (unsigned)sizeof now.rays);
    CHECK(0, mlrt_trace_packet(now.tree, &longer.rays, NULL, &now.hits), STRUCT_SIZE, text);
}

static void check_building(void)
{
    static const uint32_t far[3] = {0, 1, 9};
    CHECK(now.build.preset = 3, BUILD, ARGUMENT, "options.preset: 3 is not from 0 to 2");
    CHECK(now.build.preset = -1, BUILD, ARGUMENT, "options.preset: -1 is not from 0 to 2");
    CHECK(now.build.traversal_cost = -0.5f, BUILD, ARGUMENT, "options.traversal_cost: -0.5 is not from 0 to 1e6");
    CHECK(now.build.intersection_cost = NAN, BUILD, ARGUMENT, "options.intersection_cost: NaN is not from 0 to 1e6");
    CHECK(now.kdbuild.preset = 3, BUILD_KD, ARGUMENT, "options.preset: 3 is not from 0 to 1");
    CHECK(now.kdbuild.traversal_cost = 2e6f, BUILD_KD, ARGUMENT,
          "options.traversal_cost: 2000000 is not from 0 to 1e6");
    CHECK(now.kdbuild.intersection_cost = -INFINITY, BUILD_KD, ARGUMENT,
          "options.intersection_cost: -inf is not from 0 to 1e6");
    CHECK(now.kdbuild.max_depth = 61, BUILD_KD, ARGUMENT, "options.max_depth: 61 is not from 0 to 60");
    CHECK(now.kdbuild.rules_off = 32, BUILD_KD, ARGUMENT, "options.rules_off: 32 is not from 0 to 31");
    CHECK((now.build.host = &now.host, now.host.reserved = 5), BUILD, ARGUMENT, "options.host.reserved: 5 is not 0");
    CHECK((now.build.host = &now.host, now.host.free = (mlrt_free_callback)(uintptr_t)16), BUILD, ARGUMENT,
          "options.host: `allocate` without `free`, or `free` without `allocate`");
    CHECK((now.build.host = &now.host, now.host.progress = stop), BUILD, CANCELLED, "stopped by the host");
    CHECK(now.build.memory_limit = 1, BUILD, OUT_OF_MEMORY, "out of memory: 0 bytes held, limit 1");
    CHECK(0, mlrt_build_tree(NULL, 1, NULL, &now.made), ARGUMENT, "meshes: NULL, but mesh_count is not 0");
    CHECK(0, mlrt_build_tree(now.meshes, (size_t)1 << 31, NULL, &now.made), TOO_LARGE,
          "mesh_count: 2147483648 is more than 2147483647");
    CHECK(now.meshes[1].struct_size = 60, BUILD, STRUCT_SIZE, "meshes[1].struct_size: 60 is not that of element 0, 64");
    CHECK(now.meshes[1].index_size = 3, BUILD, ARGUMENT, "meshes[1].index_size: 3 is not 2 or 4");
    CHECK(now.meshes[1].vertices = NULL, BUILD, ARGUMENT, "meshes[1].vertices: NULL, but vertex_count is not 0");
    CHECK(now.meshes[1].vertex_stride = 13, BUILD, ARGUMENT, "meshes[1].vertices: stride 13 is not a multiple of 4");
    CHECK(now.meshes[1].vertex_stride = 8, BUILD, ARGUMENT, "meshes[1].vertices: stride 8 is less than 12");
    CHECK((now.meshes[1].indices = far, now.meshes[1].triangle_stride = 8), BUILD, ARGUMENT,
          "meshes[1].indices: stride 8 is less than 12");
    CHECK(now.meshes[1].triangle_count = (size_t)1 << 30, BUILD, TOO_LARGE,
          "meshes[1].triangle_count: 1073741825 triangles up to here are more than 1073741823");
    CHECK(now.meshes[1].indices = far, BUILD, INDEX_RANGE,
          "meshes[1], triangle 0: vertex index 9 is out of range (vertex_count is 3)");
    CHECK(now.meshes[1].indices = far, mlrt_hash_geometry(now.meshes, 2, &now.hash), INDEX_RANGE,
          "meshes[1], triangle 0: vertex index 9 is out of range (vertex_count is 3)");
    CHECK(pretended = MANY_QUADS, BUILD, TOO_LARGE,
          "meshes: the tree would have more than 268435455 nodes, or 536870911 quads of triangles");
    CHECK(now.meshes[0].id = now.meshes[1].id = 7, BUILD, ARGUMENT, "meshes[1].id: 7 is the id of meshes[0] too");
    CHECK(now.meshes[1].id = MLRT_NONE, BUILD, ARGUMENT, "meshes[1].id: MLRT_NONE stands for no mesh");
}

/* Loads a file whose word at `offset` is another, and whose hash is right unless the word is one of the hash. */
static int32_t load_changed(size_t size, size_t offset, uint32_t word)
{
    static unsigned char saved[sizeof bytes];
    memcpy(saved, bytes, size);
    memcpy(bytes + offset, &word, sizeof word);
    if (offset != FILE_HASH) repair_hash(bytes, size);
    const int32_t status = LOAD(size);
    memcpy(bytes, saved, size);
    return status;
}

/* ---- forged trees ---- */

/* A tree to change at will, before it is saved and loaded: its arrays are here, and have room for more nodes. */
static struct {
    struct mlrt_tree tree;
    uint32_t first[4], by_id[3], ids[3];
    struct mlrt_bvh_node boxes[MLRT_BVH_DEPTH_LIMIT + 1];
    float corners[2 * 36 + 16];
    uint32_t quads[2 * 4 + 16], places[2];
    struct mlrt_triangle triangles[2];
    struct mlrt_node nodes[2 * MLRT_DEPTH_LIMIT + 3];
    uint32_t references[2];
} forged;

/*
 * Makes a copy of a tree of two triangles. Triangles are read where `tree` has them while the copy is saved, so that
 * saving it does no harm.
 */
static void start_forgery(const mlrt_tree *tree)
{
    memset(&forged, 0, sizeof forged);
    memcpy(forged.first, tree->meshes.first, (tree->meshes.count + 1) * sizeof *forged.first);
    memcpy(forged.by_id, tree->meshes.by_id, tree->meshes.count * sizeof *forged.by_id);
    memcpy(forged.ids, tree->meshes.ids, tree->meshes.count * sizeof *forged.ids);
    for (uint32_t i = 0; i < 2; i++) forged.triangles[i] = mlrt_triangle_at(&tree->by_number, i);
    forged.tree = *tree;
    forged.tree.meshes.first = forged.first;
    forged.tree.meshes.by_id = forged.by_id;
    forged.tree.meshes.ids = forged.ids;
    if (tree->info.structure == MLRT_STRUCTURE_BVH) {
        assert_true(tree->bvh.node_count <= 1 && tree->bvh.quad_count <= 2);
        if (tree->bvh.node_count == 1) forged.boxes[0] = tree->bvh.nodes[0];
        memcpy(forged.corners, tree->bvh.corners, (36 * (size_t)tree->bvh.quad_count + 16) * sizeof *forged.corners);
        memcpy(forged.quads, tree->bvh.numbers, (4 * (size_t)tree->bvh.quad_count + 16) * sizeof *forged.quads);
        memcpy(forged.places, tree->bvh.places, sizeof forged.places);
        forged.tree.bvh.nodes = forged.boxes;
        forged.tree.bvh.corners = forged.corners;
        forged.tree.bvh.numbers = forged.quads;
        forged.tree.bvh.places = forged.places;
    } else {
        assert_true(tree->kdtree.node_count == 1 && tree->kdtree.reference_count == 2);
        memcpy(forged.nodes, tree->kdtree.nodes, sizeof *forged.nodes);
        memcpy(forged.references, tree->kdtree.references, sizeof forged.references);
        forged.tree.triangles = forged.triangles;
        forged.tree.kdtree.nodes = forged.nodes;
        forged.tree.kdtree.references = forged.references;
    }
}

/* Saves the forged tree and loads it. */
static int32_t load_forged(void)
{
    static unsigned char file[32768];
    size_t size;
    assert_int_equal(mlrt_save_tree(&forged.tree, file, sizeof file, &size), MLRT_OK);
    return mlrt_load_tree(file, size, &now.load, &now.made);
}

#define FORGE(tree, change, text) (start_forgery(tree), CHECK(change, load_forged(), DATA, text))

/* Gives the root no children. */
static void empty_root(void)
{
    for (int k = 0; k < 3; k++) {
        forged.boxes[0].lo[k][0] = INFINITY;
        forged.boxes[0].hi[k][0] = -INFINITY;
    }
    forged.boxes[0].child[0] = 0;
}

/* Each node is the child of the one before it: one more than a path may have. */
static void chain_boxes(void)
{
    for (uint32_t i = 0; i <= MLRT_BVH_DEPTH_LIMIT; i++) {
        forged.boxes[i] = forged.boxes[0];
        forged.boxes[i].child[0] = (i + 1) << 3;
    }
    forged.tree.bvh.node_count = MLRT_BVH_DEPTH_LIMIT + 1;
}

/* The lower child of each inner node is an inner node: one more than a path may have. */
static void chain_nodes(void)
{
    for (uint32_t i = 0; i <= MLRT_DEPTH_LIMIT; i++) {
        const uint32_t parent = i == 0 ? 0 : 2 * i - 1;
        forged.nodes[parent].u.split = forged.tree.bounds.hi[0];
        forged.nodes[parent].word = (2 * i + 1) << 2;
        forged.nodes[2 * i + 1].word = forged.nodes[2 * i + 2].word = 3;
    }
    forged.tree.kdtree.node_count = 2 * MLRT_DEPTH_LIMIT + 3;
}

/* Replaces the corners of triangle 0 by a line, which is to be left out. */
static void flatten_triangle(void)
{
    for (int row = 0; row < 9; row++) forged.corners[4 * row] = 0;
    memset(&forged.triangles[0], 0, sizeof forged.triangles[0]);
    forged.tree.info.zero_area_count = 1;
}

/* Keeps the triangles in order, as trees do that are too large for places. */
static void put_in_order(void)
{
    forged.tree.triangles = forged.triangles;
    forged.tree.bvh.places = NULL;
}

/* Three meshes, of which the second ends before it begins. */
static void add_mesh(void)
{
    forged.tree.meshes.count = 3;
    forged.first[1] = 2, forged.first[2] = 1, forged.first[3] = 2;
    forged.by_id[2] = 2, forged.ids[2] = 9;
}

static void forge_boxes(const mlrt_tree *two, const mlrt_tree *half, const mlrt_tree *none)
{
    struct mlrt_bvh *const bvh = &forged.tree.bvh;
    struct mlrt_bvh_node *const root = &forged.boxes[0];
    FORGE(two, forged.first[0] = 1, "data: meshes are out of order");
    FORGE(two, add_mesh(), "data: meshes are out of order");
    FORGE(two, forged.first[1] = 3, "data: meshes have not as many triangles as the tree");
    FORGE(two, (forged.first[1] = 2, forged.first[2] = 1), "data: meshes have not as many triangles as the tree");
    FORGE(two, forged.by_id[0] = 2, "data: a position is not that of a mesh");
    FORGE(two, forged.ids[0] = 1, "data: ids of meshes are not in order, or not different");
    FORGE(two, forged.ids[1] = MLRT_NONE, "data: ids of meshes are not in order, or not different");
    FORGE(two, forged.places[0] = MLRT_NONE, "data: P1: a place is in no quad");
    FORGE(two, forged.tree.info.bounds_max[0] = 2, "data: bounds are wrong");
    FORGE(two, forged.tree.info.zero_area_count = 1, "data: triangles are miscounted");
    FORGE(two, bvh->node_count = bvh->leaf_quad_count = 0, "data: there are triangles, but no boxes");
    FORGE(none, bvh->unit *= 2, "data: the unit is not that of the triangles");
    FORGE(two, root->child[0] = 7u << 3, "data: B1: a child is not where depth-first order has it");
    FORGE(two, bvh->node_count = 2, "data: B1: there are nodes without a parent");
    FORGE(two, root->child[2] = 1, "data: B2: an empty slot is not empty");
    FORGE(two, empty_root(), "data: B2: a node has no children");
    FORGE(two, root->hi[0][0] = NAN, "data: B3: a box is not one, or not within the bounds");
    FORGE(two, chain_boxes(), "data: B4: a path is too long");
    FORGE(two, root->child[0] = 5, "data: B5: a leaf has too many quads");
    FORGE(two, root->child[0] = 1u << 3 | 1, "data: a leaf's quads are not where depth-first order has them");
    FORGE(half, bvh->leaf_quad_count = 2, "data: there are quads without a leaf");
    FORGE(two, forged.quads[0] = MLRT_NONE, "data: B5: a leaf has a quad without triangles");
    FORGE(two, forged.quads[0] = 2, "data: B5: a number is not a triangle's");
    FORGE(two, forged.quads[1] = forged.quads[0], "data: B5: a leaf holds a triangle twice");
    FORGE(two, forged.quads[3] = 0, "data: B5: a triangle behind an empty place");
    FORGE(two, forged.corners[3] = 0, "data: B5: an empty place has corners");
    FORGE(two, flatten_triangle(), "data: a leaf holds a triangle that was to be left out");
    FORGE(two, (put_in_order(), forged.corners[0] = 9), "data: B5: corners are not those of the triangle");
    FORGE(half, forged.quads[4] = 0, "data: P1: a number has its place elsewhere");
    FORGE(half, forged.quads[4] = MLRT_NONE, "data: P1: a triangle is not at its place");
}

static void forge_kdtree(const mlrt_tree *two)
{
    struct mlrt_node *const root = &forged.nodes[0];
    FORGE(two, forged.tree.kdtree.node_count = 2, "data: I1: the number of nodes is even");
    FORGE(two, root->word = 7u << 2, "data: I1: children are not where depth-first order has them");
    FORGE(two, forged.tree.kdtree.node_count = 3, "data: I1: there are nodes without a parent");
    FORGE(two, (forged.tree.kdtree.node_count = 3, root->word = 1u << 2, root->u.split = NAN),
          "data: I2: a plane is outside of its cell");
    FORGE(two, chain_nodes(), "data: I4: a path is too long");
    FORGE(two, forged.references[1] = 0, "data: I5: the entries of a leaf are not ascending");
    FORGE(two, forged.references[1] = 2, "data: an entry is not a triangle");
    FORGE(two, flatten_triangle(), "data: a leaf refers to a triangle that was to be left out");
    FORGE(two, root->u.offset = 1, "data: a leaf's entries are not where depth-first order has them");
    FORGE(two, root->word = 1u << 2 | 3, "data: there are entries without a leaf");
}

/* What a damaged file, or one that somebody made up, is refused for. */
static void check_damage(size_t size)
{
    CHECK(0, load_changed(size, 0, 1), DATA, "data: not a saved tree");
    CHECK(0, load_changed(size, FILE_BYTE_ORDER, 0x04030201), DATA, "data: saved on a machine of another byte order");
    CHECK(0, load_changed(size, FILE_VERSION, 99), DATA, "data: of another version of the format");
    CHECK(0, load_changed(size, FILE_STRUCTURE, 9), DATA, "data: counts that no tree has");
    CHECK(0, load_changed(size, FILE_SECTIONS, 0), DATA, "data: sections are not where they have to be");
    CHECK(0, load_changed(size, FILE_HASH, 1), DATA, "data: damaged: its hash is not that of its contents");
    CHECK(now.load.geometry_hash = 1, LOAD(size), DATA, "data: of other triangles");
    memset(bytes + FILE_GEOMETRY_HASH, 0, 8);
    CHECK(now.load.geometry_hash = 1, load_changed(size, FILE_GEOMETRY_HASH, 1), DATA, "data: of other triangles");

    mlrt_tree *const two = build_structure(now.meshes, 2, MLRT_STRUCTURE_BVH);
    mlrt_tree *const two_of_kdtree = build_structure(now.meshes, 2, MLRT_STRUCTURE_KDTREE);
    now.meshes[1].vertices = flat;
    mlrt_tree *const half = build_structure(now.meshes, 2, MLRT_STRUCTURE_BVH);
    now.meshes[0].vertices = flat;
    mlrt_tree *const none = build_structure(now.meshes, 2, MLRT_STRUCTURE_BVH);
    now = right;
    forge_boxes(two, half, none);
    forge_kdtree(two_of_kdtree);
    mlrt_destroy_tree(two);
    mlrt_destroy_tree(two_of_kdtree);
    mlrt_destroy_tree(half);
    mlrt_destroy_tree(none);
}

static void check_saving(void)
{
    char text[128];
    size_t size;
    assert_int_equal(mlrt_save_tree(now.tree, bytes, sizeof bytes, &size), MLRT_OK);
    snprintf(text, sizeof text, "capacity: 10 is less than the %u bytes of the tree", (unsigned)size);
    CHECK(0, mlrt_save_tree(now.tree, bytes, 10, &now.size), ARGUMENT, text);
    CHECK(now.load.flags = 2, LOAD(size), ARGUMENT, "options.flags: 2 is not from 0 to 1");
    CHECK(0, LOAD(20), DATA, "data: not a saved tree");
    CHECK(0, LOAD(size - 1), DATA, "data: not as long as it was: cut off, or followed by something");
    CHECK(now.load.geometry_hash = 1, LOAD(size), DATA, "data: of other triangles");
    CHECK(now.load.memory_limit = 1, LOAD(size), OUT_OF_MEMORY, "out of memory");
    check_damage(size);
    CHECK(0, mlrt_create_pool(2000, &now.pool), ARGUMENT, "thread_count: 2000 is not from 0 to 1024");
    CHECK((pretended = NO_MORE_THREADS, now.pool_options.thread_count = 3), POOL, THREAD,
          "the system would not start a thread");
    CHECK(now.pool_options.finish = finish_nothing, POOL, ARGUMENT, "options.finish: given, but enqueue is NULL");
    CHECK(now.pool_options.thread_count = 1025, POOL, ARGUMENT, "options.thread_count: 1025 is not from 0 to 1024");
    CHECK(now.pool_options.enqueue = enqueue_nothing, POOL, ARGUMENT, "options.finish: NULL, but enqueue is given");
}

static void check_options(void)
{
#define OPTION(change, text)                                                                                           \
    CHECK(change, PACKET, ARGUMENT, text);                                                                             \
    CHECK(change, RAY, ARGUMENT, text);                                                                                \
    CHECK(change, RENDER, ARGUMENT, text)
    OPTION(now.options.query = 2, "options.query: 2 is not from 0 to 1");
    OPTION(now.options.method = -1, "options.method: -1 is not from 0 to 5");
    OPTION(now.options.isa = 6, "options.isa: 6 is not from 0 to 5");
    OPTION(now.options.culling = 2, "options.culling: 2 is not from 0 to 1");
    OPTION(now.options.culling_check = 2, "options.culling_check: 2 is not from 0 to 1");
    OPTION(now.options.outputs = 64, "options.outputs: 64 is not from 0 to 63");
    OPTION(now.options.shortcuts_off = 8, "options.shortcuts_off: 8 is not from 0 to 7");
    OPTION(now.options.light_count = 9, "options.light_count: 9 is not from 0 to 8");
    OPTION(now.options.reserved = 1, "options.reserved: 1 is not 0");
    OPTION(now.options.split_factor = 5, "options.split_factor: 5 is not 0, 4 or 16");
    OPTION(now.options.initial_tile_size = 12, "options.initial_tile_size: 12 is not a power of two from 4 to 1024");
    OPTION((now.options.initial_tile_size = 8, now.options.minimum_tile_size = 16),
           "options.minimum_tile_size: 16 is not a power of two from 4 to 8");
    OPTION((now.options.counters = &now.counters, now.counters.reserved = 1), "options.counters.reserved: 1 is not 0");
    CHECK((now.options.counters = &now.counters, now.counters.reserved = 1), ALL, ARGUMENT,
          "options.counters.reserved: 1 is not 0");
    CHECK((now.options.counters = &now.counters, now.counters.reserved = 1), POINTS, ARGUMENT,
          "options.counters.reserved: 1 is not 0");
    OPTION((now.options.host = &now.host, now.host.reserved = 1), "options.host.reserved: 1 is not 0");
#define HOST(object, call)                                                                                             \
    CHECK((now.object.host = &now.host, now.host.reserved = 1), call, ARGUMENT, "options.host.reserved: 1 is not 0")
    HOST(options, ALL);
    HOST(options, POINTS);
    HOST(kdbuild, BUILD_KD);
    HOST(load, LOAD(sizeof bytes));
    HOST(pool_options, POOL);
#define ISA(call)                                                                                                      \
    CHECK((pretended = NO_AVX512, mlrt_known_isa = 0, now.options.isa = MLRT_ISA_AVX512), call, UNSUPPORTED,           \
          "options.isa: 4 is not in this build, or not on this machine")
    ISA(PACKET);
    ISA(RAY);
    ISA(ALL);
    ISA(RENDER);
    ISA(POINTS);
    CHECK(now.options.method = MLRT_METHOD_PACKET4, PACKET, UNSUPPORTED,
          "options.method: 3 is for kd-trees, and the tree is one of boxes");
    CHECK((now.tree = now.kdtree, now.options.method = MLRT_METHOD_TILE), RAY, UNSUPPORTED,
          "options.method: 5 is for boxes, and the tree is a kd-tree");
    CHECK(now.options.lights = now.lights, PACKET, ARGUMENT, "options.lights: only mlrt_render_tiles takes lights");
    CHECK(now.options.light_count = 1, RENDER, ARGUMENT, "options.lights: NULL, but light_count is not 0");
    CHECK((now.options.lights = now.lights, now.options.light_count = 1, now.options.query = MLRT_QUERY_ANY,
           now.hits.occluded.data = bytes, now.hits.t.data = NULL),
          RENDER, ARGUMENT, "options.lights: given, but query ANY takes no lights");
    CHECK(now.options.query = MLRT_QUERY_ANY, PACKET, ARGUMENT,
          "options.query: ANY writes only `occluded`, but `t` was given");
    CHECK(now.hits.occluded.data = bytes, PACKET, ARGUMENT,
          "options.query: CLOSEST writes `occluded` only with lights, but it was given");
    CHECK((now.options.lights = now.lights, now.options.light_count = 2, now.lights[1].kind = 2), RENDER, ARGUMENT,
          "options.lights[1].kind: 2 is not from 0 to 1");
    CHECK(now.light.position[1] = INFINITY, POINTS, ARGUMENT, "light.position: inf is not finite");
}

static void check_arrays(void)
{
    char text[128];
    CHECK(now.rays.t_max = ((mlrt_const_array){numbers, 13}), PACKET, ARGUMENT,
          "rays.t_max: stride 13 is not a multiple of 4");
#define INPUT(call, object, field)                                                                                     \
    CHECK(now.object.field = ((mlrt_const_array){numbers, 6}), call, ARGUMENT,                                         \
          #object "." #field ": stride 6 is not a multiple of 4")
    INPUT(PACKET, rays, origins);
    INPUT(ALL, rays, directions);
    INPUT(PACKET, rays, t_min);
    INPUT(PACKET, rays, skip);
    INPUT(ALL, rays, mask);
    INPUT(POINTS, points, positions);
    INPUT(POINTS, points, skip);
    CHECK(now.rays.origins.stride = (size_t)-12, PACKET, ARGUMENT,
          "rays.origins: stride 18446744073709551604 is more than 2147483648");
    snprintf(text, sizeof text, "rays.mask: address %llu is not a multiple of 4",
             (unsigned long long)(uintptr_t)numbers + 2);
    now.rays.mask.data = (unsigned char *)numbers + 2;
    const int32_t got = PACKET;
    assert_int_equal(got, MLRT_ERROR_ARGUMENT);
    assert_string_equal(mlrt_last_message(), text); // not in the list: addresses differ from run to run
    now = right;
    CHECK(now.rays.origins.data = NULL, PACKET, ARGUMENT, "rays.origins: NULL, but count is not 0");
    CHECK(now.rays.directions.data = NULL, ALL, ARGUMENT, "rays.directions: NULL, but count is not 0");
    CHECK(now.rays.reserved = 4, PACKET, ARGUMENT, "rays.reserved: 4 is not 0");
    CHECK(now.rays.count = (size_t)1 << 31, PACKET, TOO_LARGE, "rays.count: 2147483648 is more than 2147483647");
    CHECK(now.rays.rays_per_origin = 3, PACKET, ARGUMENT, "rays.rays_per_origin: 3 does not divide count 4");
    CHECK(now.hits.reserved = 4, PACKET, ARGUMENT, "hits.reserved: 4 is not 0");
#define OUTPUT(call, object, field)                                                                                    \
    CHECK(now.object.field = ((mlrt_array){numbers, 2, 0}), call, ARGUMENT,                                            \
          #object "." #field ": stride 2 is not a multiple of 4")
    OUTPUT(PACKET, hits, t);
    OUTPUT(PACKET, hits, u);
    OUTPUT(PACKET, hits, v);
    OUTPUT(PACKET, hits, mesh);
    OUTPUT(PACKET, hits, triangle);
    OUTPUT(PACKET, hits, facing);
    CHECK(now.hits.occluded = ((mlrt_array){numbers, (size_t)-1, 0}), PACKET, ARGUMENT,
          "hits.occluded: stride MLRT_STRIDE_ALL is only for arrays of rays and points");
    OUTPUT(ALL, lists, t);
    OUTPUT(ALL, lists, u);
    OUTPUT(ALL, lists, v);
    OUTPUT(ALL, lists, mesh);
    OUTPUT(ALL, lists, triangle);
    OUTPUT(ALL, lists, facing);
    CHECK(now.lists.crossing = ((mlrt_array){numbers, ((size_t)1 << 31) + 1, 0}), ALL, ARGUMENT,
          "lists.crossing: stride 2147483649 is more than 2147483648");
    OUTPUT(ALL, lists, total);
    OUTPUT(ALL, lists, crossing_total);
    CHECK(now.hits.t.stride = MLRT_STRIDE_ALL, PACKET, ARGUMENT,
          "hits.t: stride MLRT_STRIDE_ALL is only for arrays of rays and points");
    CHECK(now.hits.t.row_stride = 13, RENDER, ARGUMENT, "frame.t: row stride 13 is not a multiple of 4");
    CHECK(now.hits.t.row_stride = ((size_t)1 << 31) + 4, RENDER, ARGUMENT,
          "frame.t: row stride 2147483652 is more than 2147483648");
    CHECK(now.hits.t.data = NULL, PACKET, ARGUMENT, "hits: no array is given, so nothing would be written");
    CHECK(now.hits.t.data = NULL, RENDER, ARGUMENT, "frame: no array is given, so nothing would be written");
    CHECK(now.lists.total.data = NULL, ALL, ARGUMENT, "lists: no array is given, so nothing would be written");
#define LIST(field)                                                                                                    \
    CHECK(now.lists.field.data = numbers, ALL, ARGUMENT, "lists.capacity: 0, but `" #field "` was given")
    LIST(t);
    LIST(u);
    LIST(v);
    LIST(mesh);
    LIST(triangle);
    LIST(facing);
    LIST(crossing);
    CHECK(now.points.positions.data = NULL, POINTS, ARGUMENT, "points.positions: NULL, but count is not 0");
    CHECK(now.points.count = (size_t)1 << 31, POINTS, TOO_LARGE, "points.count: 2147483648 is more than 2147483647");
    CHECK(now.dark.stride = (size_t)1 << 32, POINTS, ARGUMENT, "occluded: stride 4294967296 is more than 2147483648");
    CHECK(now.vectors.stride = 8, WRITE_RAYS, ARGUMENT, "origins: stride 8 is less than 12");
    CHECK(now.vectors.row_stride = 6, WRITE_RAYS, ARGUMENT, "origins: row stride 6 is not a multiple of 4");
}

static void check_cameras(void)
{
#define VIEW(change, status, text)                                                                                     \
    CHECK(change, RENDER, status, text);                                                                               \
    CHECK(change, WRITE_RAYS, status, text)
    VIEW(now.camera.projection = 2, ARGUMENT, "camera.projection: 2 is not from 0 to 1");
    VIEW(now.camera.width = 0, CAMERA, "camera.width: 0 is not from 1 to 8388608");
    VIEW(now.camera.height = 8388609, TOO_LARGE, "camera.height: 8388609 is not from 1 to 8388608");
    VIEW(now.camera.crop_x = 2, CAMERA, "camera.crop_x: 2 is not less than width 2");
    VIEW((now.camera.crop_y = 1, now.camera.crop_height = 2), CAMERA,
         "camera.crop_height: 2 from crop_y 1 on is more than height 2");
    VIEW(now.camera.width = now.camera.height = 65536, TOO_LARGE,
         "camera.crop_width: 65536 x crop_height 65536 are more pixels than 2147483647");
    VIEW(now.camera.d00[2] = -INFINITY, CAMERA, "camera.d00: -inf is not finite");
    VIEW(now.camera.dx[0] = NAN, CAMERA, "camera.dx: NaN is not finite");
    VIEW(now.camera.dy[1] = INFINITY, CAMERA, "camera.dy: inf is not finite");
    VIEW(now.camera.sample_x = INFINITY, CAMERA, "camera.sample_x: inf is not finite");
    VIEW(now.camera.sample_y = NAN, CAMERA, "camera.sample_y: NaN is not finite");
    VIEW(now.camera.t_min = NAN, CAMERA, "camera.t_min: NaN is not a number");
    VIEW(now.camera.t_max = NAN, CAMERA, "camera.t_max: NaN is not a number");
    VIEW(now.camera.eye[0] = INFINITY, CAMERA, "camera.eye: inf is not finite");
    VIEW((now.camera.projection = 1, now.camera.direction[0] = INFINITY), CAMERA,
         "camera.direction: inf is not finite");
    VIEW((now.camera.projection = 1, memset(now.camera.direction, 0, 12)), CAMERA, "camera.direction: all of it is 0");
    VIEW(memcpy(now.camera.dx, now.camera.dy, 12), CAMERA, "camera.dx: it is parallel to dy, or one of them is 0");
    CHECK(0, mlrt_render_tiles(now.tree, &now.camera, NULL, NULL, stop_tile, NULL), CANCELLED, "stopped by a callback");
}

static void check_single(void)
{
    CHECK(now.ray.flags = 2, RAY, ARGUMENT, "ray.flags: 2 is not from 0 to 1");
    CHECK(now.ray.flags = 2, SHADOW, ARGUMENT, "ray.flags: 2 is not from 0 to 1");
    CHECK(now.hit.triangle = 5, SHADOW, ARGUMENT, "hit.triangle: there is no triangle 5 in a mesh with id 0");
    CHECK(now.ray.direction[2] = -1, SHADOW, ARGUMENT, "hit.triangle: the ray does not hit triangle 0 of mesh 0");
    CHECK(0, OFFSET(5, 0, 0, 1), ARGUMENT, "triangle: there is no triangle 5 in a mesh with id 0");
    CHECK(0, OFFSET(0, INFINITY, 0, 1), ARGUMENT, "u: inf is not finite");
    CHECK(0, OFFSET(0, 0, NAN, 1), ARGUMENT, "v: NaN is not finite");
    CHECK(0, OFFSET(0, 0, 0, 0), ARGUMENT, "side: 0 is not 1 or -1");
    mlrt_mesh mesh = now.meshes[0];
    mlrt_tree *lines = NULL, *wide = NULL;
    mesh.vertices = large;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &wide), MLRT_OK);
    CHECK(now.tree = wide, OFFSET(0, 3e38f, 0, 1), ARGUMENT, "point: it would leave the range of float");
    mesh.vertices = flat;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &lines), MLRT_OK);
    CHECK(now.tree = lines, OFFSET(0, 0, 0, 1), ARGUMENT, "triangle: it is not finite, or has no area");
    mlrt_destroy_tree(lines);
    mlrt_destroy_tree(wide);
}

static void each_check_has_its_message(void **state)
{
    (void)state;
    set_up();
    listing[0] = 0;
    check_null();
    check_sizes();
    check_building();
    check_saving();
    check_options();
    check_arrays();
    check_cameras();
    check_single();
    is_complete = 1;
    mlrt_destroy_tree(right.tree);
    mlrt_destroy_tree(right.kdtree);
}

static void the_documentation_lists_all_checks(void **state)
{
    (void)state;
    static char page[1 << 16];
    const char *const begin = "| --- | --- |\n", *const end = "<!-- end of table -->";
    if (sizeof(void *) == 4) skip(); // sizes of structs are those of 64-bit machines
    FILE *file = fopen("docs/errors.md", "rb");
    assert_non_null(file);
    page[fread(page, 1, sizeof page - 1, file)] = 0;
    fclose(file);
    char *table = strstr(page, begin), *rest = table ? strstr(table, end) : NULL;
    assert_non_null(rest);
    table += strlen(begin);
    assert_true(is_complete);
    if (getenv("WRITE_ERRORS")) {
        file = fopen("docs/errors.md", "wb");
        assert_non_null(file);
        fprintf(file, "%.*s%s%s", (int)(table - page), page, listing, rest);
        fclose(file);
        return;
    }
    *rest = 0;
    assert_string_equal(table, listing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_thread_has_its_own),
        cmocka_unit_test(each_check_has_its_message),
        cmocka_unit_test(the_documentation_lists_all_checks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
