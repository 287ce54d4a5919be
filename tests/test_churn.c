/* SPDX-License-Identifier: MIT */
/*
 * Trees and pools made and destroyed over and over: what the process holds at the end is what it held after the first
 * few. CHURN_CYCLES in the environment says how often; `make check-churn` takes 10,000, under valgrind. So no other
 * library is linked that valgrind might have something to say about.
 */
#define _POSIX_C_SOURCE 200809L // posix_memalign

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <cmocka.h>

#include "mlrt.h"

enum { TRIANGLES = 60, RAYS = 64 };

static size_t cycle_count(void)
{
    const char *text = getenv("CHURN_CYCLES");
    long count = text ? strtol(text, NULL, 10) : 0;
    return count > 0 ? (size_t)count : 200;
}

/* What glibc keeps at hand for a thread counts as handed out: some 64 sizes up to 1 kB, seven of each. */
#define AT_HAND ((size_t)1 << 18)

/* Bytes that malloc has handed out; 0 where it does not tell. */
static size_t held_by_malloc(void)
{
#if defined(__GLIBC__) && defined(__GLIBC_PREREQ)
#if __GLIBC_PREREQ(2, 33)
    struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
#endif
#endif
    return 0;
}

/* Bytes in memory; 0 where nothing tells. */
static size_t resident_size(void)
{
    unsigned long whole = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file) return 0;
    if (fscanf(file, "%lu %lu", &whole, &resident) != 2) resident = 0;
    fclose(file);
    return resident * 4096;
}

/* ---- a host that counts ------------------------------------------------------------------------------------------ */

struct heap {
    size_t block_count;
    size_t held_size;
};

static void *allocate(void *user, size_t size, size_t alignment)
{
    struct heap *heap = user;
    void *block;
    if (posix_memalign(&block, alignment < sizeof(void *) ? sizeof(void *) : alignment, size) != 0) return NULL;
    ++heap->block_count;
    heap->held_size += size;
    return block;
}

static void give_back(void *user, void *block, size_t size, size_t alignment)
{
    struct heap *heap = user;
    (void)alignment;
    --heap->block_count;
    heap->held_size -= size;
    free(block);
}

/* ---- one cycle --------------------------------------------------------------------------------------------------- */

static float draw(uint32_t *state, float limit)
{
    *state = *state * 1664525u + 1013904223u;
    return limit * ((float)(*state >> 8) / 8388608.0f - 1);
}

/* Every kind of tree in turn: boxes of three presets, kd-trees of two. */
static int32_t build(size_t cycle, const mlrt_mesh *mesh, mlrt_pool *pool, const mlrt_host *host, uint64_t memory_limit,
                     mlrt_tree **tree)
{
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes,
                                     .preset = (int32_t)(cycle % 5),
                                     .pool = cycle / 5 % 4 ? pool : NULL,
                                     .host = host,
                                     .memory_limit = memory_limit};
    const mlrt_kdtree_options kdtree = {
        .struct_size = sizeof kdtree, .preset = (int32_t)(cycle % 5) - 3, .host = host, .memory_limit = memory_limit};
    return cycle % 5 < 3 ? mlrt_build_tree(mesh, 1, &boxes, tree) : mlrt_build_kdtree(mesh, 1, &kdtree, tree);
}

/* A pool, a tree, some rays, and two builds that fail. */
static void run_cycle(size_t cycle, const mlrt_host *host)
{
    float corners[9 * TRIANGLES];
    uint32_t random = (uint32_t)cycle % 16;
    for (size_t i = 0; i < 9 * TRIANGLES; i++) corners[i] = draw(&random, 1);
    const uint32_t wrong[3] = {0, 1, 3 * TRIANGLES};
    mlrt_mesh mesh = {
        .struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3 * TRIANGLES, .triangle_count = TRIANGLES};
    mlrt_pool_options pool_options = {.struct_size = sizeof pool_options, .thread_count = 1 + cycle % 3, .host = host};
    mlrt_pool *pool = NULL;
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_create_pool_with_options(&pool_options, &pool), MLRT_OK);

    assert_int_equal(build(cycle, &mesh, pool, host, 0, &tree), MLRT_OK);

    float origins[3 * RAYS], directions[3 * RAYS], t[RAYS];
    for (size_t i = 0; i < 3 * RAYS; i++) {
        origins[i] = draw(&random, 2);
        directions[i] = draw(&random, 1);
    }
    mlrt_rays rays = {
        .struct_size = sizeof rays, .count = RAYS, .origins = {origins, 0}, .directions = {directions, 0}};
    mlrt_hits hits = {.struct_size = sizeof hits, .t = {t, 0, 0}};
    mlrt_trace_options trace = {.struct_size = sizeof trace, .pool = pool, .host = host};
    assert_int_equal(mlrt_trace_packet(tree, &rays, &trace, &hits), MLRT_OK);
    uint32_t total[RAYS];
    mlrt_hit_lists lists = {.struct_size = sizeof lists, .total = {total, 0, 0}};
    assert_int_equal(mlrt_trace_all_hits(tree, &rays, &trace, &lists), MLRT_OK);
    mlrt_destroy_tree(tree);

    mesh.indices = wrong;
    mesh.triangle_count = 1;
    assert_int_equal(build(cycle, &mesh, pool, host, 0, &tree), MLRT_ERROR_INDEX_RANGE);
    mesh.indices = NULL;
    mesh.triangle_count = TRIANGLES;
    assert_int_equal(build(cycle, &mesh, pool, host, 1000 + 100 * (cycle % 50), &tree), MLRT_ERROR_OUT_OF_MEMORY);
    assert_null(tree);
    mlrt_destroy_pool(pool);
}

static void nothing_grows(void **state)
{
    (void)state;
    struct heap heap = {0, 0};
    const mlrt_host host = {
        .struct_size = sizeof host, .user = &heap, .allocate = allocate, .free = give_back, .log = NULL};
    size_t count = cycle_count(), warm = count / 10 < 60 ? 60 : count / 10; // 60: each combination once
    if (warm > count) count = warm;
    size_t held_first = held_by_malloc(), held_warm = 0, resident_warm = 0;
    for (size_t cycle = 0; cycle < count; cycle++) {
        if (cycle == warm) {
            held_warm = held_by_malloc();
            resident_warm = resident_size();
        }
        run_cycle(cycle, cycle % 2 ? &host : NULL);
        assert_int_equal(heap.block_count, 0);
        assert_int_equal(heap.held_size, 0);
    }
    size_t held_last = held_by_malloc(), resident_last = resident_size();
    print_message(
        "%zu cycles. Held by malloc: %zu bytes before, %zu after %zu, %zu at the end. In memory: %zu kB after "
        "%zu, %zu kB at the end.\n",
        count, held_first, held_warm, warm, held_last, resident_warm / 1024, warm, resident_last / 1024);
    if (count > warm) assert_true(held_last <= held_warm + AT_HAND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_grows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
