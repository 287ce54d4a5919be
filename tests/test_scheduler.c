/* SPDX-License-Identifier: MIT */
/*
 * Pools and threads: pools of every size give the same answers, may be shared, used at once with others, made and ended
 * again and again; callbacks can end a render.
 */
#define _GNU_SOURCE /* pthread_getattr_np, where there is glibc */

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { WIDTH = 90, HEIGHT = 70 };

static struct fixture torus(void)
{
    struct soup soup = {0};
    soup_add_torus(&soup, 30, 16, 1, 0.4f);
    return fixture_of_soup("torus", 1, &soup);
}

static mlrt_camera view(void)
{
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    return look_at(eye, target, 1, WIDTH, HEIGHT);
}

/* What every picture of `view` must be. */
static void expected_picture(const struct fixture *fixture, float t[WIDTH * HEIGHT])
{
    mlrt_camera camera = view();
    struct ray_list list = {0};
    add_camera_rays(&list, &camera);
    for (size_t i = 0; i < list.count; i++) {
        struct reference_hit hit;
        reference_trace(fixture->reference, &list.rays[i], &hit);
        t[i] = hit.t;
    }
    free_rays(&list);
}

static int32_t render(const mlrt_tree *tree, mlrt_pool *pool, uint32_t tile_size, float t[WIDTH * HEIGHT])
{
    mlrt_camera camera = view();
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
    mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool, .initial_tile_size = tile_size};
    memset(t, 0xA5, WIDTH * HEIGHT * sizeof *t);
    return mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL);
}

static mlrt_pool *pool_of(uint32_t threads)
{
    mlrt_pool *pool = NULL;
    assert_int_equal(mlrt_create_pool(threads, &pool), MLRT_OK);
    assert_non_null(pool);
    return pool;
}

static void pools_of_every_size_draw_the_same(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {1, 2, 3, 8, 64, 0};
    static float expected[WIDTH * HEIGHT], got[WIDTH * HEIGHT];
    struct fixture fixture = torus();
    expected_picture(&fixture, expected);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        mlrt_pool *pool = pool_of(sizes[i]);
        for (int n = 0; n < 5; n++) {
            assert_int_equal(render(fixture.tree, pool, n % 2 ? 4 : 16, got), MLRT_OK);
            assert_memory_equal(expected, got, sizeof got);
        }
        mlrt_destroy_pool(pool);
    }
    free_fixture(&fixture);
}

static void pools_of_every_size_trace_the_same_rays(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {1, 2, 3, 8, 64, 0};
    struct random random = {2};
    struct fixture fixture = torus();
    struct ray_list list = {0};
    add_mixed_rays(&list, &random, &fixture, 3000, -2, 2);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    float *got = allocate_or_fail(list.count, sizeof *got);
    trace_reference(&fixture, &list, expected);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        mlrt_pool *pool = pool_of(sizes[i]);
        mlrt_rays rays = public_rays(&list);
        mlrt_hits hits = {.struct_size = sizeof hits, .t = {got, 0, 0}};
        mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool, .initial_tile_size = 4};
        assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &hits), MLRT_OK);
        for (size_t r = 0; r < list.count; r++) assert_int_equal(bits_of_float(got[r]), bits_of_float(expected[r].t));
        mlrt_destroy_pool(pool);
    }
    free(expected);
    free(got);
    free_rays(&list);
    free_fixture(&fixture);
}

static void pools_come_and_go(void **state)
{
    (void)state;
    static float got[WIDTH * HEIGHT];
    struct fixture fixture = torus();
    for (uint32_t i = 0; i < 200; i++) {
        mlrt_pool *pool = pool_of(1 + i % 5);
        if (i % 20 == 0) assert_int_equal(render(fixture.tree, pool, 16, got), MLRT_OK);
        mlrt_destroy_pool(pool);
    }
    free_fixture(&fixture);
}

static void many_pools_live_at_once(void **state)
{
    (void)state;
    static float expected[WIDTH * HEIGHT], got[WIDTH * HEIGHT];
    mlrt_pool *pools[16];
    struct fixture fixture = torus();
    expected_picture(&fixture, expected);
    for (int i = 0; i < 16; i++) pools[i] = pool_of(3);
    for (int i = 0; i < 16; i++) {
        assert_int_equal(render(fixture.tree, pools[i], 16, got), MLRT_OK);
        assert_memory_equal(expected, got, sizeof got);
    }
    for (int i = 0; i < 16; i++) mlrt_destroy_pool(pools[15 - i]);
    free_fixture(&fixture);
}

static void a_pool_can_be_used_many_times(void **state)
{
    (void)state;
    struct fixture fixture = torus();
    mlrt_pool *pool = pool_of(4);
    float origin[3] = {0, -3, 0}, direction[3] = {0.3f, 1, 0}, t;
    struct ray_list list = {0};
    struct reference_hit expected;
    add_ray(&list, origin, direction);
    trace_reference(&fixture, &list, &expected);
    for (size_t i = 0; i < scaled(4000); i++) {
        mlrt_rays rays = public_rays(&list);
        mlrt_hits hits = {.struct_size = sizeof hits, .t = {&t, 0, 0}};
        mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool};
        assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &hits), MLRT_OK);
        assert_int_equal(bits_of_float(t), bits_of_float(expected.t));
    }
    mlrt_destroy_pool(pool);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- several callers --------------------------------------------------------------------------------------------- */

enum { CALLS = 12 };

struct caller {
    const struct fixture *fixture;
    const float *expected;
    mlrt_pool *pool;
    int failures;
};

/* Not a place for assertions: cmocka jumps out of the thread that the test runs in. */
static void *call_repeatedly(void *argument)
{
    struct caller *caller = argument;
    float *got = malloc(WIDTH * HEIGHT * sizeof *got);
    for (int i = 0; got && i < CALLS; i++) {
        caller->failures += render(caller->fixture->tree, caller->pool, 16, got) != MLRT_OK;
        caller->failures += memcmp(got, caller->expected, WIDTH * HEIGHT * sizeof *got) != 0;
    }
    caller->failures += !got;
    free(got);
    return NULL;
}

static void call_from_threads(mlrt_pool *first, mlrt_pool *second, mlrt_pool *third)
{
    static float expected[WIDTH * HEIGHT];
    struct fixture fixture = torus();
    expected_picture(&fixture, expected);
    struct caller callers[3] = {
        {&fixture, expected, first, 0}, {&fixture, expected, second, 0}, {&fixture, expected, third, 0}};
    pthread_t threads[3];
    for (int i = 0; i < 3; i++) assert_int_equal(pthread_create(&threads[i], NULL, call_repeatedly, &callers[i]), 0);
    for (int i = 0; i < 3; i++) assert_int_equal(pthread_join(threads[i], NULL), 0);
    for (int i = 0; i < 3; i++) assert_int_equal(callers[i].failures, 0);
    free_fixture(&fixture);
}

static void threads_trace_one_tree_at_once(void **state)
{
    (void)state;
    call_from_threads(NULL, NULL, NULL);
}

static void threads_with_pools_of_their_own(void **state)
{
    (void)state;
    mlrt_pool *pools[3] = {pool_of(2), pool_of(3), pool_of(1)};
    call_from_threads(pools[0], pools[1], pools[2]);
    for (int i = 0; i < 3; i++) mlrt_destroy_pool(pools[i]);
}

static void threads_that_share_a_pool(void **state)
{
    (void)state;
    mlrt_pool *pool = pool_of(3);
    call_from_threads(pool, pool, pool);
    mlrt_destroy_pool(pool);
}

static void *build_repeatedly(void *argument)
{
    struct soup *soup = argument;
    mlrt_mesh mesh = soup_mesh(soup);
    uint64_t *hash = malloc(sizeof *hash);
    for (int i = 0; hash && i < 5; i++) {
        mlrt_tree *tree = NULL;
        mlrt_tree_info info = {.struct_size = sizeof info};
        *hash = 0;
        if (mlrt_build_tree(&mesh, 1, NULL, &tree) != MLRT_OK) break;
        mlrt_get_tree_info(tree, &info);
        mlrt_destroy_tree(tree);
        *hash = info.tree_hash;
    }
    return hash;
}

static void trees_are_built_at_once_and_alike(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_icosphere(&soup, 3, 1);
    pthread_t threads[3];
    void *hashes[3];
    for (int i = 0; i < 3; i++) assert_int_equal(pthread_create(&threads[i], NULL, build_repeatedly, &soup), 0);
    for (int i = 0; i < 3; i++) assert_int_equal(pthread_join(threads[i], &hashes[i]), 0);
    for (int i = 0; i < 3; i++) {
        assert_non_null(hashes[i]);
        assert_true(*(uint64_t *)hashes[i] != 0 && *(uint64_t *)hashes[i] == *(uint64_t *)hashes[0]);
    }
    for (int i = 0; i < 3; i++) free(hashes[i]);
    free_soup(&soup);
}

/* ---- callbacks --------------------------------------------------------------------------------------------------- */

struct counter {
    pthread_mutex_t mutex;
    int calls;
    int stop_at;
    int foreign_zero; /* calls as worker 0 from another thread than the caller's */
    int own_other;    /* calls from the caller's thread as another worker than 0 */
    pthread_t caller;
};

static int32_t count_calls(void *user, const mlrt_tile *tile)
{
    struct counter *counter = user;
    pthread_mutex_lock(&counter->mutex);
    int calls = ++counter->calls;
    int own = pthread_equal(pthread_self(), counter->caller);
    counter->foreign_zero += tile->worker == 0 && !own;
    counter->own_other += tile->worker != 0 && own;
    pthread_mutex_unlock(&counter->mutex);
    return counter->stop_at && calls >= counter->stop_at;
}

static int32_t render_counted(const mlrt_tree *tree, uint32_t threads, struct counter *counter)
{
    mlrt_camera camera = view();
    mlrt_trace_options options = {.struct_size = sizeof options, .initial_tile_size = 8, .pool = shared_pool(threads)};
    pthread_mutex_init(&counter->mutex, NULL);
    counter->caller = pthread_self();
    int32_t status = mlrt_render_tiles(tree, &camera, &options, NULL, count_calls, counter);
    pthread_mutex_destroy(&counter->mutex);
    return status;
}

enum { TILES = ((WIDTH + 7) / 8) * ((HEIGHT + 7) / 8) };

static void each_tile_calls_once(void **state)
{
    (void)state;
    struct fixture fixture = torus();
    for (uint32_t threads = 0; threads < 4; threads++) {
        struct counter counter = {.calls = 0};
        assert_int_equal(render_counted(fixture.tree, threads, &counter), MLRT_OK);
        assert_int_equal(counter.calls, TILES);
    }
    free_fixture(&fixture);
}

static void worker_0_is_the_caller(void **state)
{
    (void)state;
    struct fixture fixture = torus();
    for (uint32_t threads = 0; threads < 4; threads++) {
        struct counter counter = {.calls = 0};
        assert_int_equal(render_counted(fixture.tree, threads, &counter), MLRT_OK);
        assert_int_equal(counter.foreign_zero, 0);
        assert_int_equal(counter.own_other, 0);
    }
    free_fixture(&fixture);
}

static void a_callback_can_cancel_at_any_tile(void **state)
{
    (void)state;
    struct fixture fixture = torus();
    for (uint32_t threads = 0; threads < 4; threads++) {
        for (int stop = 1; stop <= TILES; stop += 13) {
            struct counter counter = {.stop_at = stop};
            assert_int_equal(render_counted(fixture.tree, threads, &counter), MLRT_ERROR_CANCELLED);
            // Tiles that others had begun may still be handed out.
            assert_in_range(counter.calls, stop, stop + (int)threads);
        }
    }
    free_fixture(&fixture);
}

static void a_cancelled_pool_goes_on_working(void **state)
{
    (void)state;
    static float expected[WIDTH * HEIGHT], got[WIDTH * HEIGHT];
    struct fixture fixture = torus();
    struct counter counter = {.stop_at = 3};
    expected_picture(&fixture, expected);
    assert_int_equal(render_counted(fixture.tree, 3, &counter), MLRT_ERROR_CANCELLED);
    assert_int_equal(render(fixture.tree, shared_pool(3), 16, got), MLRT_OK);
    assert_memory_equal(expected, got, sizeof got);
    free_fixture(&fixture);
}

static int32_t return_value(void *user, const mlrt_tile *tile)
{
    (void)tile;
    return *(int32_t *)user;
}

static void any_value_but_zero_cancels(void **state)
{
    (void)state;
    static const int32_t values[] = {1, -1, INT32_MIN, MLRT_ERROR_ARGUMENT};
    struct fixture fixture = torus();
    mlrt_camera camera = view();
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        int32_t value = values[i];
        int32_t status = mlrt_render_tiles(fixture.tree, &camera, NULL, NULL, return_value, &value);
        assert_int_equal(status, MLRT_ERROR_CANCELLED);
    }
    free_fixture(&fixture);
}

struct nested {
    const mlrt_tree *tree;
    int failures[8];
};

/* Traces a ray through the middle of the torus, and a picture, from inside the callback. */
static int32_t trace_inside(void *user, const mlrt_tile *tile)
{
    struct nested *nested = user;
    struct reference_ray ray = {{0, -3, 0}, {0, 1, 0}, 0, INFINITY, {MLRT_NONE, MLRT_NONE}};
    mlrt_ray single = {.struct_size = sizeof single, .direction = {0, 1, 0}};
    memcpy(single.origin, ray.origin, sizeof single.origin);
    mlrt_hit hit = {.struct_size = sizeof hit};
    float t[9];
    mlrt_camera camera = view();
    camera.crop_width = camera.crop_height = 3;
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
    int failed = mlrt_trace_ray(nested->tree, &single, NULL, &hit) != MLRT_OK || hit.mesh != 0;
    failed |= mlrt_render_tiles(nested->tree, &camera, NULL, &frame, NULL, NULL) != MLRT_OK;
    nested->failures[tile->worker % 8] += failed;
    return 0;
}

static void a_callback_may_trace(void **state)
{
    (void)state;
    struct fixture fixture = torus();
    struct nested nested = {.tree = fixture.tree};
    mlrt_camera camera = view();
    for (uint32_t threads = 0; threads < 4; threads += 3) {
        mlrt_trace_options options = {
            .struct_size = sizeof options, .initial_tile_size = 16, .pool = shared_pool(threads)};
        assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, NULL, trace_inside, &nested), MLRT_OK);
    }
    for (int i = 0; i < 8; i++) assert_int_equal(nested.failures[i], 0);
    free_fixture(&fixture);
}

/* Counters of all workers end up in one struct. */
static void counters_of_a_pool_add_up(void **state)
{
    (void)state;
    static float got[WIDTH * HEIGHT];
    struct fixture fixture = torus();
    mlrt_camera camera = view();
    mlrt_counters alone = {.struct_size = sizeof alone}, shared = alone;
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {got, 0, 0}};
    mlrt_trace_options options = {.struct_size = sizeof options, .counters = &alone};
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
    options.counters = &shared;
    options.pool = shared_pool(8);
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
    assert_memory_equal(&alone, &shared, sizeof alone);
    free_fixture(&fixture);
}

#if defined(__GLIBC__)
enum { SMALL_STACK_SIZE = 1 << 17, LEAST_STACK_SIZE = 1 << 20 };

static int32_t note_stack_size(void *user_data, const mlrt_tile *tile)
{
    size_t *sizes = user_data;
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0) return 1;
    (void)pthread_attr_getstacksize(&attributes, &sizes[tile->worker]);
    (void)pthread_attr_destroy(&attributes);
    return 0;
}

/* Some systems give threads as little as a call needs by itself. */
static void threads_have_room_for_callbacks(void **state)
{
    (void)state;
    struct fixture fixture = torus();
    const mlrt_camera camera = view();
    size_t sizes[3] = {0};
    pthread_attr_t usual, small;
    assert_int_equal(pthread_getattr_default_np(&usual), 0);
    assert_int_equal(pthread_attr_init(&small), 0);
    assert_int_equal(pthread_attr_setstacksize(&small, SMALL_STACK_SIZE), 0);
    assert_int_equal(pthread_setattr_default_np(&small), 0);
    mlrt_pool *pool = pool_of(3);
    assert_int_equal(pthread_setattr_default_np(&usual), 0);
    const mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool, .initial_tile_size = 4};
    for (int i = 0; i < 1000 && !(sizes[1] && sizes[2]); i++) {
        assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &options, NULL, note_stack_size, sizes), MLRT_OK);
    }
    assert_true(sizes[1] >= LEAST_STACK_SIZE && sizes[2] >= LEAST_STACK_SIZE);
    mlrt_destroy_pool(pool);
    (void)pthread_attr_destroy(&small);
    (void)pthread_attr_destroy(&usual);
    free_fixture(&fixture);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pools_of_every_size_draw_the_same),
        cmocka_unit_test(pools_of_every_size_trace_the_same_rays),
        cmocka_unit_test(pools_come_and_go),
        cmocka_unit_test(many_pools_live_at_once),
        cmocka_unit_test(a_pool_can_be_used_many_times),
        cmocka_unit_test(threads_trace_one_tree_at_once),
        cmocka_unit_test(threads_with_pools_of_their_own),
        cmocka_unit_test(threads_that_share_a_pool),
        cmocka_unit_test(trees_are_built_at_once_and_alike),
        cmocka_unit_test(each_tile_calls_once),
        cmocka_unit_test(worker_0_is_the_caller),
        cmocka_unit_test(a_callback_can_cancel_at_any_tile),
        cmocka_unit_test(a_cancelled_pool_goes_on_working),
        cmocka_unit_test(any_value_but_zero_cancels),
        cmocka_unit_test(a_callback_may_trace),
        cmocka_unit_test(counters_of_a_pool_add_up),
#if defined(__GLIBC__)
        cmocka_unit_test(threads_have_room_for_callbacks),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
