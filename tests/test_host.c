/* SPDX-License-Identifier: MIT */
/*
 * What the program around the library provides: memory that can run out anywhere, a log, progress that can be stopped
 * anywhere, and tasks that run at once, on other threads, or only when they are waited for.
 */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "support.h"

/* ---- a host that keeps books ------------------------------------------------------------------------------------- */

struct books {
    pthread_mutex_t mutex;
    size_t held_size;
    size_t peak_size;
    uint32_t block_count;
    uint32_t allocation_count;
    uint32_t fail_from; /* the number of the first allocation that fails; 0 = none does */
    int misaligned;     /* blocks 16 bytes off */
    uint32_t line_count[3];
    char last_line[300];
    uint32_t tell_count;
    uint32_t stop_at; /* tell_count at which to cancel; 0 = never */
    double last_fraction;
    uint32_t end_count;
    int went_back;
    int inside; /* progress calls at one time */
    int overlapped;
};

#define MARGIN 192

/* A block with its size and alignment in front, as asked for. */
static void *take_block(void *user, size_t size, size_t alignment)
{
    struct books *books = user;
    assert_true(size > 0);
    assert_int_equal(alignment, 64);
    pthread_mutex_lock(&books->mutex);
    const int fails = books->fail_from && ++books->allocation_count >= books->fail_from;
    if (!books->fail_from) ++books->allocation_count;
    char *start = fails ? NULL : malloc(size + MARGIN);
    if (start) {
        ++books->block_count;
        books->held_size += size;
        if (books->held_size > books->peak_size) books->peak_size = books->held_size;
    }
    pthread_mutex_unlock(&books->mutex);
    if (!start) return NULL;
    char *block = start + 64 + (64 - (uintptr_t)start % 64) % 64;
    memcpy(block - 8, &start, sizeof start);
    memcpy(block - 16, &size, sizeof size);
    return books->misaligned ? block - 32 : block;
}

static void give_block(void *user, void *given, size_t size, size_t alignment)
{
    struct books *books = user;
    char *block = books->misaligned ? (char *)given + 32 : given, *start;
    size_t had;
    assert_non_null(given);
    assert_int_equal(alignment, 64);
    memcpy(&start, block - 8, sizeof start);
    memcpy(&had, block - 16, sizeof had);
    assert_int_equal(size, had);
    pthread_mutex_lock(&books->mutex);
    --books->block_count;
    books->held_size -= size;
    pthread_mutex_unlock(&books->mutex);
    free(start);
}

static void take_line(void *user, int32_t level, const char *message)
{
    struct books *books = user;
    assert_in_range(level, MLRT_LOG_ERROR, MLRT_LOG_INFO);
    assert_null(strchr(message, '\n'));
    ++books->line_count[level];
    strncpy(books->last_line, message, sizeof books->last_line - 1);
}

static int32_t take_progress(void *user, double fraction)
{
    struct books *books = user;
    if (__atomic_exchange_n(&books->inside, 1, __ATOMIC_SEQ_CST)) books->overlapped = 1;
    if (!(fraction >= books->last_fraction && fraction <= 1)) books->went_back = 1;
    books->last_fraction = fraction < 1 ? fraction : 0; /* the next is of another call */
    if (fraction == 1) ++books->end_count;
    const int stop = ++books->tell_count == books->stop_at;
    __atomic_store_n(&books->inside, 0, __ATOMIC_SEQ_CST);
    return stop ? 7 : 0;
}

static void open_books(struct books *books)
{
    memset(books, 0, sizeof *books);
    pthread_mutex_init(&books->mutex, NULL);
}

static mlrt_host host_with(struct books *books)
{
    return (mlrt_host){.struct_size = sizeof(mlrt_host),
                       .user = books,
                       .allocate = take_block,
                       .free = give_block,
                       .log = take_line,
                       .progress = take_progress};
}

static void assert_balanced(const struct books *books)
{
    assert_int_equal(books->block_count, 0);
    assert_int_equal(books->held_size, 0);
    assert_false(books->went_back);
    assert_false(books->overlapped);
}

/* ---- something to do --------------------------------------------------------------------------------------------- */

static struct soup some_soup(size_t count)
{
    struct random random = {77};
    struct soup soup = {NULL, 0, 0};
    soup_add_random(&soup, &random, count, 10, 1);
    return soup;
}

enum { BUILD_BOXES, BUILD_KDTREE, TRACE, TRACE_ALL, RENDER, RENDER_SHADOWS, OCCLUDE, CALL_COUNT };

#define SIDE (SANITIZED ? 128 : 256)
#define RAYS (SIDE * SIDE)

/* A call of each kind, with results into arrays that are large enough. */
struct scene {
    struct soup soup;
    mlrt_mesh mesh;
    mlrt_tree *tree;
    mlrt_camera camera;
    float *origins;
    float *directions;
    uint32_t *ids;
    uint8_t *occluded;
};

static int32_t ignore_tile(void *user, const mlrt_tile *tile)
{
    (void)user;
    return tile->width == 0;
}

static int32_t make_call(const struct scene *scene, int kind, const mlrt_host *host, mlrt_pool *pool)
{
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes, .pool = pool, .host = host};
    const mlrt_kdtree_options kdtree = {
        .struct_size = sizeof kdtree, .preset = MLRT_KDTREE_TUNED, .host = host, .pool = pool}; // more progress
    mlrt_trace_options trace = {
        .struct_size = sizeof trace, .pool = pool, .host = host, .outputs = MLRT_OUTPUT_T | MLRT_OUTPUT_IDS};
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = RAYS,
                            .origins = {scene->origins, 0},
                            .directions = {scene->directions, 0}};
    const mlrt_points points = {.struct_size = sizeof points, .count = RAYS, .positions = {scene->directions, 0}};
    const mlrt_light light = {.struct_size = sizeof light, .position = {1, 2, 3}};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {scene->ids, 0, 0}};
    const mlrt_hits shadows = {.struct_size = sizeof shadows, .occluded = {scene->occluded, 0, 0}};
    const mlrt_hit_lists lists = {.struct_size = sizeof lists, .capacity = 1, .triangle = {scene->ids, 0, 0}};
    const mlrt_array occluded = {scene->occluded, 0, 0};
    mlrt_tree *tree = (mlrt_tree *)(uintptr_t)16;
    int32_t status = MLRT_OK;
    switch (kind) {
    case BUILD_BOXES:
    case BUILD_KDTREE:
        status = kind == BUILD_BOXES ? mlrt_build_tree(&scene->mesh, 1, &boxes, &tree)
                                     : mlrt_build_kdtree(&scene->mesh, 1, &kdtree, &tree);
        assert_int_equal(status == MLRT_OK, tree != NULL);
        mlrt_destroy_tree(tree);
        return status;
    case TRACE:
        return mlrt_trace_packet(scene->tree, &rays, &trace, &hits);
    case TRACE_ALL:
        return mlrt_trace_all_hits(scene->tree, &rays, &trace, &lists);
    case RENDER_SHADOWS:
        trace.lights = &light;
        trace.light_count = 1;
        trace.outputs = MLRT_OUTPUT_OCCLUDED;
        return mlrt_render_tiles(scene->tree, &scene->camera, &trace, &shadows, ignore_tile, NULL);
    case RENDER:
        return mlrt_render_tiles(scene->tree, &scene->camera, &trace, &hits, ignore_tile, NULL);
    default:
        return mlrt_occluded_points(scene->tree, &points, &light, &trace, &occluded);
    }
}

static int set_up(void **state)
{
    struct scene *scene = allocate_or_fail(1, sizeof *scene);
    const float eye[3] = {5, 5, -20}, target[3] = {5, 5, 5};
    scene->soup = some_soup(scaled(10000));
    scene->mesh = soup_mesh(&scene->soup);
    scene->camera = look_at(eye, target, 1, SIDE, SIDE);
    scene->origins = allocate_or_fail(3 * RAYS, sizeof(float));
    scene->directions = allocate_or_fail(3 * RAYS, sizeof(float));
    scene->ids = allocate_or_fail(RAYS, sizeof(uint32_t));
    scene->occluded = allocate_or_fail(RAYS, 1);
    const mlrt_array origins = {scene->origins, 0, 0}, directions = {scene->directions, 0, 0};
    if (mlrt_camera_rays(&scene->camera, &origins, &directions) != MLRT_OK) return 1;
    *state = scene;
    return mlrt_build_tree(&scene->mesh, 1, NULL, &scene->tree) != MLRT_OK;
}

static int tear_down(void **state)
{
    struct scene *scene = *state;
    mlrt_destroy_tree(scene->tree);
    free(scene->occluded);
    free(scene->ids);
    free(scene->directions);
    free(scene->origins);
    free_soup(&scene->soup);
    free(scene);
    return 0;
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static void all_memory_comes_from_the_host(void **state)
{
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        struct books books;
        open_books(&books);
        const mlrt_host host = host_with(&books);
        assert_int_equal(make_call(*state, kind, &host, shared_pool(2)), MLRT_OK);
        assert_true(books.allocation_count > 0);
        assert_balanced(&books);
    }
}

/* Whichever allocation is the first to fail: the right answer, and nothing is lost. */
static void memory_runs_out_anywhere(void **state)
{
    struct scene scene = *(struct scene *)*state;
    if (scene.mesh.triangle_count > 5000) scene.mesh.triangle_count = 5000; /* each block costs a build */
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        int32_t status = MLRT_ERROR_OUT_OF_MEMORY;
        uint32_t fail_from = 1;
        for (; status != MLRT_OK; fail_from++) {
            struct books books;
            open_books(&books);
            books.fail_from = fail_from;
            const mlrt_host host = host_with(&books);
            status = make_call(&scene, kind, &host, shared_pool(2));
            if (status != MLRT_OK) assert_int_equal(status, MLRT_ERROR_OUT_OF_MEMORY);
            assert_balanced(&books);
            assert_true(fail_from < 1000);
        }
        assert_true(fail_from > 2);
    }
}

static void a_host_that_does_not_align_is_out_of_memory(void **state)
{
    struct books books;
    open_books(&books);
    books.misaligned = 1;
    const mlrt_host host = host_with(&books);
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        assert_int_equal(make_call(*state, kind, &host, NULL), MLRT_ERROR_OUT_OF_MEMORY);
        assert_balanced(&books);
    }
}

static void both_functions_or_neither(void **state)
{
    struct books books;
    open_books(&books);
    mlrt_host host = host_with(&books);
    host.free = NULL;
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        assert_int_equal(make_call(*state, kind, &host, NULL), MLRT_ERROR_ARGUMENT);
    }
    host = host_with(&books);
    host.struct_size = 8;
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        assert_int_equal(make_call(*state, kind, &host, NULL), MLRT_ERROR_STRUCT_SIZE);
    }
}

enum { KIND_COUNT = 5 };

/* Boxes of the presets, then kd-trees; and what the builder foresees. `message` has 200 bytes. */
static int32_t build_kind(int32_t kind, const mlrt_mesh *mesh, const mlrt_host *host, uint64_t memory_limit,
                          char *message, mlrt_tree **tree, mlrt_memory_estimate *estimate)
{
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes,
                                     .preset = kind,
                                     .message = message,
                                     .message_size = 200,
                                     .host = host,
                                     .memory_limit = memory_limit};
    const mlrt_kdtree_options kdtree = {.struct_size = sizeof kdtree,
                                        .preset = kind - MLRT_TREE_BEST - 1,
                                        .message = message,
                                        .message_size = 200,
                                        .host = host,
                                        .memory_limit = memory_limit};
    if (kind <= MLRT_TREE_BEST) {
        assert_int_equal(mlrt_estimate_tree(mesh, 1, &boxes, estimate), MLRT_OK);
        return mlrt_build_tree(mesh, 1, &boxes, tree);
    }
    assert_int_equal(mlrt_estimate_kdtree(mesh, 1, &kdtree, estimate), MLRT_OK);
    return mlrt_build_kdtree(mesh, 1, &kdtree, tree);
}

/* The report agrees with the books, and so does what was foreseen. */
static void sizes_are_those_of_the_books(void **state)
{
    const struct scene *scene = *state;
    for (int32_t kind = 0; kind < KIND_COUNT; kind++) {
        struct books books;
        open_books(&books);
        const mlrt_host host = host_with(&books);
        mlrt_tree *tree;
        mlrt_tree_info info = {.struct_size = sizeof info};
        mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
        char message[200];
        assert_int_equal(build_kind(kind, &scene->mesh, &host, 0, message, &tree, &estimate), MLRT_OK);
        assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
        assert_int_equal(info.memory_size, books.held_size);
        assert_int_equal(info.peak_memory_size, books.peak_size);
        /*
         * Of boxes it has a margin for scenes with many spatial splits. Of a kd-tree it is a guess, and this is a soup.
         */
        const uint64_t least = info.memory_size / 4, least_peak = info.peak_memory_size / 4;
        const int boxes = kind <= MLRT_TREE_BEST;
        assert_in_range(estimate.memory_size, (boxes ? 3 : 2) * least, (boxes ? 6 : 12) * least);
        assert_in_range(estimate.peak_memory_size, (boxes ? 3 : 2) * least_peak, (boxes ? 5 : 12) * least_peak);
        mlrt_destroy_tree(tree);
        assert_balanced(&books);
    }
}

/* Nothing but the counts of triangles is looked at. */
static void estimates_need_no_meshes(void **state)
{
    (void)state;
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .triangle_count = 1000000};
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    assert_int_equal(mlrt_estimate_tree(&mesh, 1, NULL, &estimate), MLRT_OK);
    assert_in_range(estimate.memory_size, 50000000, 70000000);
    assert_in_range(estimate.peak_memory_size, 110000000, 150000000);
    mlrt_memory_estimate with_mask = estimate;
    mesh.mask = 1;
    assert_int_equal(mlrt_estimate_tree(&mesh, 1, NULL, &with_mask), MLRT_OK);
    assert_int_equal(with_mask.memory_size - estimate.memory_size, 4000000);
    assert_int_equal(with_mask.peak_memory_size - estimate.peak_memory_size, 4000000);
    assert_int_equal(mlrt_estimate_tree(NULL, 0, NULL, &estimate), MLRT_OK);
    assert_int_equal(mlrt_estimate_tree(NULL, 1, NULL, &estimate), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_estimate_tree(&mesh, 1, NULL, NULL), MLRT_ERROR_ARGUMENT);
    estimate.struct_size = 4;
    assert_int_equal(mlrt_estimate_tree(&mesh, 1, NULL, &estimate), MLRT_ERROR_STRUCT_SIZE);
    mesh.triangle_count = (size_t)1 << 30;
    estimate.struct_size = sizeof estimate;
    assert_int_equal(mlrt_estimate_tree(&mesh, 1, NULL, &estimate), MLRT_ERROR_TOO_LARGE);
}

/* A limit at the peak is enough, one byte less is not; and the message says so. */
static void a_limit_is_kept(void **state)
{
    const struct scene *scene = *state;
    for (int32_t kind = 0; kind < KIND_COUNT; kind++) {
        char message[200];
        struct books books;
        open_books(&books);
        const mlrt_host host = host_with(&books);
        mlrt_tree *tree;
        mlrt_tree_info info = {.struct_size = sizeof info};
        mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
        assert_int_equal(build_kind(kind, &scene->mesh, &host, 0, message, &tree, &estimate), MLRT_OK);
        assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
        mlrt_destroy_tree(tree);
        const uint64_t peak = info.peak_memory_size;
        assert_int_equal(build_kind(kind, &scene->mesh, &host, peak, message, &tree, &estimate), MLRT_OK);
        mlrt_destroy_tree(tree);
        assert_int_equal(build_kind(kind, &scene->mesh, &host, peak - 1, message, &tree, &estimate),
                         MLRT_ERROR_OUT_OF_MEMORY);
        books.last_fraction = 0;
        assert_null(tree);
        assert_true(books.peak_size <= info.peak_memory_size);
        assert_non_null(strstr(message, "limit"));
        assert_int_equal(build_kind(kind, &scene->mesh, &host, 1, message, &tree, &estimate), MLRT_ERROR_OUT_OF_MEMORY);
        assert_balanced(&books);
    }
}

/* The same without a host, where blocks are resized in place, for few triangles: some of the builder's arrays are empty. */
static void a_limit_is_kept_for_few_triangles(void **state)
{
    (void)state;
    static float vertices[3 * 3 * 20];
    struct random random = {77};
    for (size_t i = 0; i < sizeof vertices / sizeof *vertices; i++) vertices[i] = (float)draw_below(&random, 9);
    for (uint32_t count = 0; count <= 20; count++) {
        const mlrt_mesh mesh = {
            .struct_size = sizeof mesh, .vertices = vertices, .vertex_count = 3 * count, .triangle_count = count};
        for (int32_t kind = 0; kind < KIND_COUNT; kind++) {
            char message[200];
            mlrt_tree *tree;
            mlrt_tree_info info = {.struct_size = sizeof info};
            mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
            assert_int_equal(build_kind(kind, &mesh, NULL, 0, message, &tree, &estimate), MLRT_OK);
            assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
            mlrt_destroy_tree(tree);
            const uint64_t peak = info.peak_memory_size;
            assert_int_equal(build_kind(kind, &mesh, NULL, peak, message, &tree, &estimate), MLRT_OK);
            mlrt_destroy_tree(tree);
            assert_int_equal(build_kind(kind, &mesh, NULL, peak - 1, message, &tree, &estimate),
                             MLRT_ERROR_OUT_OF_MEMORY);
        }
    }
}

/* ---- log --------------------------------------------------------------------------------------------------------- */

static void the_log_tells_results_warnings_and_errors(void **state)
{
    (void)state;
    float corners[27] = {0, 0, 0, 1, 0, 0, 0, 1, 0, /* no area: */ 1, 1, 1, 1, 1, 1, 2, 2, 2};
    uint32_t indices[3] = {0, 1, 9};
    corners[20] = float_of_bits(0x7FC00000u);
    struct books books;
    open_books(&books);
    const mlrt_host host = host_with(&books);
    mlrt_tree_options options = {.struct_size = sizeof options, .host = &host};
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 9, .triangle_count = 3};
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_OK);
    assert_int_equal(books.line_count[MLRT_LOG_INFO], 1);
    assert_int_equal(books.line_count[MLRT_LOG_WARNING], 1);
    assert_int_equal(books.line_count[MLRT_LOG_ERROR], 0);
    mlrt_destroy_tree(tree);
    mesh.indices = indices;
    mesh.triangle_count = 1;
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_ERROR_INDEX_RANGE);
    assert_int_equal(books.line_count[MLRT_LOG_ERROR], 1);
    assert_non_null(strstr(books.last_line, "vertex index 9"));
    mesh.index_size = 3;
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_ERROR_ARGUMENT);
    assert_int_equal(books.line_count[MLRT_LOG_ERROR], 2);
    mesh = (mlrt_mesh){.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    books.stop_at = 1;
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_OK); /* told once, at the end */
    mlrt_destroy_tree(tree);
    assert_int_equal(books.line_count[MLRT_LOG_ERROR], 2);
}

/* Nothing stale is left in the buffer, and what is new is cut to it. */
static void messages_are_emptied(void **state)
{
    const struct scene *scene = *state;
    char message[16] = "stale";
    mlrt_tree_options options = {
        .struct_size = sizeof options, .preset = 99, .message = message, .message_size = sizeof message};
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(&scene->mesh, 1, &options, &tree), MLRT_ERROR_ARGUMENT);
    assert_string_equal(message, "options.preset:");
    options.preset = MLRT_TREE_DEFAULT;
    strcpy(message, "stale");
    assert_int_equal(mlrt_build_tree(&scene->mesh, 1, &options, &tree), MLRT_OK);
    assert_string_equal(message, "");
    mlrt_destroy_tree(tree);
    const mlrt_load_options load = {
        .struct_size = sizeof load, .flags = 99, .message = strcpy(message, "stale"), .message_size = sizeof message};
    assert_int_equal(mlrt_load_tree(message, sizeof message, &load, &tree), MLRT_ERROR_ARGUMENT);
    assert_string_equal(message, "options.flags: ");
}

/* ---- progress ---------------------------------------------------------------------------------------------------- */

static void progress_ends_at_one(void **state)
{
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        for (uint32_t threads = 0; threads <= 3; threads += 3) {
            struct books books;
            open_books(&books);
            const mlrt_host host = host_with(&books);
            assert_int_equal(make_call(*state, kind, &host, shared_pool(threads)), MLRT_OK);
            assert_true(books.tell_count > 0);
            assert_int_equal(books.end_count, 1);
            assert_balanced(&books);
        }
    }
}

/* Where there is nothing to do that is done too. */
static void progress_of_no_rays_ends_at_one(void **state)
{
    const struct scene *scene = *state;
    struct books books;
    open_books(&books);
    const mlrt_host host = host_with(&books);
    const mlrt_trace_options options = {.struct_size = sizeof options, .host = &host};
    const mlrt_rays rays = {.struct_size = sizeof rays};
    const mlrt_hits hits = {.struct_size = sizeof hits};
    const mlrt_hit_lists lists = {.struct_size = sizeof lists};
    assert_int_equal(mlrt_trace_packet(scene->tree, &rays, &options, &hits), MLRT_OK);
    assert_int_equal(books.end_count, 1);
    assert_int_equal(mlrt_trace_all_hits(scene->tree, &rays, &options, &lists), MLRT_OK);
    assert_int_equal(books.end_count, 2);
    assert_balanced(&books);
}

/* Told the n-th time, the host says stop: nothing is lost, nobody is told again, and all else still works. */
static void calls_end_when_told_to(void **state)
{
    const struct scene *scene = *state;
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        for (uint32_t threads = 0; threads <= 3; threads += 3) {
            int32_t status = MLRT_ERROR_CANCELLED;
            for (uint32_t stop_at = 1; status != MLRT_OK && stop_at < 40; stop_at += 1 + stop_at / 4) {
                struct books books;
                open_books(&books);
                books.stop_at = stop_at;
                const mlrt_host host = host_with(&books);
                status = make_call(scene, kind, &host, shared_pool(threads));
                /* Told of the end, it is too late. */
                const int was_in_time = books.tell_count == stop_at && !books.end_count;
                assert_int_equal(status, was_in_time ? MLRT_ERROR_CANCELLED : MLRT_OK);
                assert_true(books.tell_count <= stop_at);
                assert_balanced(&books);
            }
        }
    }
    assert_int_equal(make_call(scene, RENDER, NULL, NULL), MLRT_OK);
}

/* ---- tasks ------------------------------------------------------------------------------------------------------- */

enum { AT_ONCE, ON_A_THREAD, WHEN_WAITED_FOR, NEVER_BEFORE_ALL };

struct job {
    mlrt_task_function function;
    void *argument;
    pthread_t thread;
};

struct jobs {
    int how;
    pthread_mutex_t mutex;
    uint32_t enqueued_count;
    uint32_t finished_count;
};

static void *run_job(void *argument)
{
    struct job *job = argument;
    job->function(job->argument);
    return NULL;
}

static void *enqueue(void *user, mlrt_task_function function, void *argument)
{
    struct jobs *jobs = user;
    pthread_mutex_lock(&jobs->mutex);
    ++jobs->enqueued_count;
    pthread_mutex_unlock(&jobs->mutex);
    if (jobs->how == AT_ONCE) {
        function(argument);
        return NULL;
    }
    struct job *job = allocate_or_fail(1, sizeof *job);
    *job = (struct job){.function = function, .argument = argument};
    if (jobs->how == ON_A_THREAD) assert_int_equal(pthread_create(&job->thread, NULL, run_job, job), 0);
    return job;
}

static void finish(void *user, void *task)
{
    struct jobs *jobs = user;
    struct job *job = task;
    if (jobs->how == ON_A_THREAD) {
        pthread_join(job->thread, NULL);
    } else {
        job->function(job->argument);
    }
    free(job);
    pthread_mutex_lock(&jobs->mutex);
    ++jobs->finished_count;
    pthread_mutex_unlock(&jobs->mutex);
}

static mlrt_pool *task_pool(struct jobs *jobs, int how, uint32_t count, const mlrt_host *host)
{
    const mlrt_pool_options options = {.struct_size = sizeof options,
                                       .thread_count = count,
                                       .host = host,
                                       .user = jobs,
                                       .enqueue = enqueue,
                                       .finish = finish};
    mlrt_pool *pool;
    *jobs = (struct jobs){.how = how};
    pthread_mutex_init(&jobs->mutex, NULL);
    assert_int_equal(mlrt_create_pool_with_options(&options, &pool), MLRT_OK);
    return pool;
}

/*
 * Blocks with a fence behind them, which is looked at when they come back: large, as what is written there by mistake
 * is written in one go.
 */
#define FENCE_SIZE ((size_t)1 << 20)

static void *take_fenced(void *user, size_t size, size_t alignment)
{
    unsigned char *start = malloc(size + FENCE_SIZE + 2 * alignment);
    (void)user;
    if (!start) return NULL;
    unsigned char *block = start + alignment + (alignment - (uintptr_t)start % alignment) % alignment;
    memcpy(block - sizeof start, &start, sizeof start);
    memset(block + size, 0xA5, FENCE_SIZE);
    return block;
}

static void give_fenced(void *user, void *given, size_t size, size_t alignment)
{
    unsigned char *block = given, *start;
    (void)alignment;
    for (size_t i = 0; i < FENCE_SIZE; i++) *(int *)user += block[size + i] != 0xA5;
    memcpy(&start, block - sizeof start, sizeof start);
    free(start);
}

/* So slow that it is told every time that somebody looks. */
static int32_t take_slow_progress(void *user, double fraction)
{
    const struct timespec pause = {0, 1200000};
    int *left = user;
    (void)fraction;
    nanosleep(&pause, NULL);
    return --left[1] == 0;
}

/* How often it is told the same fraction: what is one piece of work, and looks again and again. */
struct repetitions {
    double fraction;
    int count;
    int most;
    int left;
};

static int32_t count_repetitions(void *user, double fraction)
{
    const struct timespec pause = {0, 1200000};
    struct repetitions *repetitions = user;
    nanosleep(&pause, NULL);
    repetitions->count = fraction == repetitions->fraction ? repetitions->count + 1 : 1;
    repetitions->fraction = fraction;
    if (repetitions->count > repetitions->most) repetitions->most = repetitions->count;
    return --repetitions->left == 0;
}

/* More than 20 chunks of triangles: first to find a split, then to apply it. */
static void one_thread_looks_up_from_large_sets(void **state)
{
    struct soup soup = some_soup(100000);
    const mlrt_mesh mesh = soup_mesh(&soup);
    struct repetitions repetitions = {.left = 110};
    const mlrt_host host = {.struct_size = sizeof host, .user = &repetitions, .progress = count_repetitions};
    const mlrt_tree_options options = {.struct_size = sizeof options, .host = &host};
    mlrt_tree *tree;
    (void)state;
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_ERROR_CANCELLED);
    assert_in_range(repetitions.most, 18, 110);
    free_soup(&soup);
}

/* Small triangles first, then so many long ones that no plane could cut them: when only the first have been counted, it
 * looks as if one could. */
static struct soup small_and_long(void)
{
    struct random random = {5};
    struct soup soup = {NULL, 0, 0};
    soup_add_random(&soup, &random, 8192, 100, 0.1f);
    for (int i = 0; i < 16000; i++) {
        const int axis = i % 3;
        float corner[3][3];
        draw_point(&random, 0, 100, corner[0]);
        memcpy(corner[1], corner[0], sizeof corner[0]);
        corner[0][axis] = 0;
        corner[1][axis] = 100;
        memcpy(corner[2], corner[1], sizeof corner[1]);
        corner[1][(axis + 1) % 3] += 0.1f;
        corner[2][axis] = draw_range(&random, 0, 100);
        corner[2][(axis + 2) % 3] += 0.1f;
        soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
    }
    return soup;
}

static void a_build_that_ends_stays_within_its_memory(void **state)
{
    struct jobs jobs;
    struct soup soup = small_and_long();
    const mlrt_mesh mesh = soup_mesh(&soup);
    mlrt_pool *pool = task_pool(&jobs, AT_ONCE, 2, NULL);
    (void)state;
    for (int stop_at = 1; stop_at <= 24; stop_at += (int)variant_step()) {
        int spoilt_and_left[2] = {0, stop_at};
        const mlrt_host host = {.struct_size = sizeof host,
                                .user = spoilt_and_left,
                                .allocate = take_fenced,
                                .free = give_fenced,
                                .progress = take_slow_progress};
        const mlrt_tree_options options = {.struct_size = sizeof options, .pool = pool, .host = &host};
        mlrt_tree *tree;
        assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_ERROR_CANCELLED);
        assert_null(tree);
        assert_int_equal(spoilt_and_left[0], 0);
    }
    mlrt_destroy_pool(pool);
    free_soup(&soup);
}

/* Blocks of exactly the size that was asked for, so that the address sanitizer sees what is read behind them. */
static void *take_exact(void *user, size_t size, size_t alignment)
{
    void *block;
    (void)user;
    return posix_memalign(&block, alignment, size) ? NULL : block;
}

static void give_exact(void *user, void *block, size_t size, size_t alignment)
{
    (void)user, (void)size, (void)alignment;
    free(block);
}

/* It has no ids to look for. */
static void a_tree_without_meshes_has_only_misses(void **state)
{
    struct scene *scene = *state;
    const mlrt_host host = {.struct_size = sizeof host, .allocate = take_exact, .free = give_exact};
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes, .host = &host};
    const mlrt_kdtree_options cells = {.struct_size = sizeof cells, .host = &host};
    mlrt_tree *trees[2];
    assert_int_equal(mlrt_build_tree(NULL, 0, &boxes, &trees[0]), MLRT_OK);
    assert_int_equal(mlrt_build_kdtree(NULL, 0, &cells, &trees[1]), MLRT_OK);
    for (int i = 0; i < 2; i++) {
        const mlrt_rays rays = {.struct_size = sizeof rays,
                                .count = RAYS,
                                .origins = {scene->origins, 0},
                                .directions = {scene->directions, 0}};
        uint32_t meshes[RAYS];
        const mlrt_hits hits = {.struct_size = sizeof hits, .mesh = {.data = meshes}, .triangle = {.data = scene->ids}};
        assert_int_equal(mlrt_trace_packet(trees[i], &rays, NULL, &hits), MLRT_OK);
        for (int ray = 0; ray < RAYS; ray++) assert_true(meshes[ray] == MLRT_NONE && scene->ids[ray] == MLRT_NONE);
        mlrt_destroy_tree(trees[i]);
    }
}

static uint64_t tree_hash(const struct scene *scene, mlrt_pool *pool)
{
    const mlrt_tree_options options = {.struct_size = sizeof options, .pool = pool};
    mlrt_tree_info info = {.struct_size = sizeof info};
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(&scene->mesh, 1, &options, &tree), MLRT_OK);
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
    mlrt_destroy_tree(tree);
    return info.tree_hash;
}

static void tasks_do_the_work_however_they_run(void **state)
{
    struct scene *scene = *state;
    uint32_t *expected = allocate_or_fail(RAYS, sizeof *expected);
    assert_int_equal(make_call(scene, RENDER, NULL, NULL), MLRT_OK);
    memcpy(expected, scene->ids, RAYS * sizeof *expected);
    const uint64_t hash = tree_hash(scene, NULL);
    for (int how = AT_ONCE; how <= WHEN_WAITED_FOR; how++) {
        struct books books;
        struct jobs jobs;
        open_books(&books);
        const mlrt_host host = host_with(&books);
        mlrt_pool *pool = task_pool(&jobs, how, 4, &host);
        assert_int_equal(books.block_count, 1);
        for (int kind = 0; kind < CALL_COUNT; kind++) {
            memset(scene->ids, 0xA5, RAYS * sizeof *scene->ids);
            assert_int_equal(make_call(scene, kind, &host, pool), MLRT_OK);
            if (kind == RENDER) assert_memory_equal(scene->ids, expected, RAYS * sizeof *expected);
        }
        assert_true(tree_hash(scene, pool) == hash);
        assert_true(jobs.enqueued_count > 3);
        assert_int_equal(jobs.finished_count, how == AT_ONCE ? 0 : jobs.enqueued_count);
        mlrt_destroy_pool(pool);
        assert_balanced(&books);
    }
    free(expected);
}

/* From within a job, with the same pool: nobody waits for anybody. */
static int32_t trace_inside(void *user, const mlrt_tile *tile)
{
    void **both = user;
    const mlrt_trace_options options = {.struct_size = sizeof options, .pool = both[1], .initial_tile_size = 4};
    const struct scene *scene = both[0];
    uint32_t ids[16 * 16];
    mlrt_camera camera = scene->camera;
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {ids, 0, 0}};
    (void)tile;
    camera.crop_width = camera.crop_height = 16;
    return mlrt_render_tiles(scene->tree, &camera, &options, &hits, NULL, NULL);
}

static void calls_within_jobs(void **state)
{
    struct scene *scene = *state;
    for (int how = AT_ONCE; how <= WHEN_WAITED_FOR; how++) {
        struct jobs jobs;
        mlrt_pool *pool = task_pool(&jobs, how, 3, NULL);
        void *both[2] = {scene, pool};
        const mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool, .initial_tile_size = 32};
        assert_int_equal(mlrt_render_tiles(scene->tree, &scene->camera, &options, NULL, trace_inside, both), MLRT_OK);
        mlrt_destroy_pool(pool);
    }
}

/* One thread and a queue, as in a small game: who waits for a task runs the oldest ones until that one is done. */
struct queue {
    struct {
        mlrt_task_function function;
        void *argument;
        int done;
    } tasks[64];
    size_t first, end;
    struct scene *scene;
    mlrt_pool *pool;
    int depth;
    int inner_count;
};

static void *put_in_queue(void *user, mlrt_task_function function, void *argument)
{
    struct queue *queue = user;
    assert_true(queue->end < 64);
    queue->tasks[queue->end].function = function;
    queue->tasks[queue->end].argument = argument;
    queue->tasks[queue->end].done = 0;
    return &queue->tasks[queue->end++].done;
}

static void work_on_queue(void *user, void *task)
{
    struct queue *queue = user;
    while (!*(int *)task) {
        const size_t next = queue->first++;
        queue->tasks[next].function(queue->tasks[next].argument);
        queue->tasks[next].done = 1;
    }
}

static int32_t trace_in_progress(void *user, double fraction)
{
    struct queue *queue = user;
    assert_int_equal(queue->depth, 0);
    if (fraction == 1 || queue->inner_count == 3) return 0;
    void *both[2] = {queue->scene, queue->pool};
    queue->depth = 1;
    assert_int_equal(trace_inside(both, NULL), 0);
    queue->depth = 0;
    ++queue->inner_count;
    return 0;
}

/* Waiting there runs tasks of the call that tells, which tell in their turn what they have done. */
static void progress_may_use_tasks(void **state)
{
    for (int kind = 0; kind < CALL_COUNT; kind++) {
        static struct queue queue;
        memset(&queue, 0, sizeof queue);
        const mlrt_pool_options options = {.struct_size = sizeof options,
                                           .thread_count = 2,
                                           .user = &queue,
                                           .enqueue = put_in_queue,
                                           .finish = work_on_queue};
        const mlrt_host host = {.struct_size = sizeof host, .user = &queue, .progress = trace_in_progress};
        assert_int_equal(mlrt_create_pool_with_options(&options, &queue.pool), MLRT_OK);
        queue.scene = *state;
        assert_int_equal(make_call(*state, kind, &host, queue.pool), MLRT_OK);
        assert_true(queue.inner_count > 0);
        mlrt_destroy_pool(queue.pool);
    }
}

static void pool_options_are_checked(void **state)
{
    (void)state;
    struct jobs jobs;
    const mlrt_pool_options good = {.struct_size = sizeof good, .thread_count = 2};
    mlrt_pool_options options = good;
    mlrt_pool *pool = (mlrt_pool *)(uintptr_t)16;
    assert_int_equal(mlrt_create_pool_with_options(NULL, &pool), MLRT_ERROR_ARGUMENT);
    assert_null(pool);
    assert_int_equal(mlrt_create_pool_with_options(&good, NULL), MLRT_ERROR_ARGUMENT);
    options.enqueue = enqueue;
    assert_int_equal(mlrt_create_pool_with_options(&options, &pool), MLRT_ERROR_ARGUMENT);
    options = good;
    options.thread_count = 1025;
    assert_int_equal(mlrt_create_pool_with_options(&options, &pool), MLRT_ERROR_ARGUMENT);
    options = good;
    options.struct_size = 0;
    assert_int_equal(mlrt_create_pool_with_options(&options, &pool), MLRT_ERROR_STRUCT_SIZE);
    assert_null(pool);
    pool = task_pool(&jobs, AT_ONCE, 1, NULL);
    mlrt_destroy_pool(pool);
    struct books books;
    open_books(&books);
    books.fail_from = 1;
    const mlrt_host host = host_with(&books);
    options = good;
    options.host = &host;
    assert_int_equal(mlrt_create_pool_with_options(&options, &pool), MLRT_ERROR_OUT_OF_MEMORY);
    assert_balanced(&books);
}

/* ---- calls that end early ---------------------------------------------------------------------------------------- */

#define STACKED_COUNT 2000

/* Triangles nearly in one plane: a ray has close calls, which look up for the host, and hits most of them. */
static mlrt_mesh stacked_triangles(float (*corners)[9])
{
    for (int i = 0; i < STACKED_COUNT; ++i) {
        const float s = 0.0001f + (float)i / (2 * STACKED_COUNT);
        const float triangle[9] = {.5f - s, .5f - s, .5f, .5f + s, .5f - s, .5f + s, .5f, .5f + s, .5f};
        memcpy(corners[i], triangle, sizeof triangle);
    }
    return (mlrt_mesh){.struct_size = sizeof(mlrt_mesh),
                       .vertices = corners,
                       .vertex_count = 3 * STACKED_COUNT,
                       .triangle_count = STACKED_COUNT};
}

/* Waits, so that each call is one that the host hears of. */
static int32_t wait_and_take_progress(void *user, double fraction)
{
    nanosleep(&(struct timespec){.tv_nsec = 1100000}, NULL);
    return take_progress(user, fraction);
}

enum { EDGE = 64 };

/* What a cancelled call has written is right. Returns whether the call was cancelled. */
static int check_cancelled(const mlrt_tree *tree, const mlrt_rays *rays, int32_t query, uint32_t stop_at,
                           const uint32_t *expected)
{
    static uint32_t found[EDGE * EDGE];
    static uint8_t occluded[EDGE * EDGE];
    struct books books;
    open_books(&books);
    books.stop_at = stop_at;
    const mlrt_host host = {.struct_size = sizeof host, .user = &books, .progress = wait_and_take_progress};
    const mlrt_trace_options options = {.struct_size = sizeof options, .query = query, .host = &host};
    mlrt_hits hits = {.struct_size = sizeof hits};
    memset(found, 0xEE, sizeof found);
    memset(occluded, 0xEE, sizeof occluded);
    if (query == MLRT_QUERY_ANY) {
        hits.occluded.data = occluded;
    } else {
        hits.triangle.data = found;
    }
    const int32_t status = mlrt_trace_packet(tree, rays, &options, &hits);
    for (uint32_t i = 0; i < EDGE * EDGE; ++i) {
        if (query == MLRT_QUERY_ANY) {
            assert_true(occluded[i] == 0xEE || occluded[i] == (expected[i] != MLRT_NONE));
        } else {
            assert_true(found[i] == 0xEEEEEEEE || found[i] == expected[i]);
        }
    }
    assert_true(status == MLRT_OK || status == MLRT_ERROR_CANCELLED);
    return status == MLRT_ERROR_CANCELLED;
}

/* A ray that was not decided when the host stopped the call is not written. */
static void cancelled_calls_write_only_results(void **state)
{
    (void)state;
    static float corners[STACKED_COUNT][9], origins[EDGE * EDGE][3], directions[EDGE * EDGE][3];
    static uint32_t expected[EDGE * EDGE];
    const mlrt_mesh mesh = stacked_triangles(corners);
    for (uint32_t i = 0; i < EDGE * EDGE; ++i) {
        const float x = .3f + .4f * (float)(i % EDGE) / EDGE, y = .3f + .4f * (float)(i / EDGE) / EDGE;
        memcpy(origins[i], ((const float[3]){.5f, .5f, -3}), 12);
        memcpy(directions[i], ((const float[3]){x - .5f, y - .5f, 3.5f}), 12);
    }
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = EDGE,
                            .count = EDGE * EDGE,
                            .origins = {origins, 0},
                            .directions = {directions, 0}};
    const mlrt_hits all = {.struct_size = sizeof all, .triangle = {.data = expected}};
    for (int boxes = 0; boxes < 2; ++boxes) {
        mlrt_tree *tree = NULL;
        uint32_t cancelled_count = 0;
        assert_int_equal(boxes ? mlrt_build_tree(&mesh, 1, NULL, &tree) : mlrt_build_kdtree(&mesh, 1, NULL, &tree),
                         MLRT_OK);
        assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &all), MLRT_OK);
        for (uint32_t stop_at = 1; stop_at < 5; stop_at += SANITIZED ? 3 : 1) {
            cancelled_count += (uint32_t)check_cancelled(tree, &rays, MLRT_QUERY_CLOSEST, stop_at, expected);
            cancelled_count += (uint32_t)check_cancelled(tree, &rays, MLRT_QUERY_ANY, stop_at, expected);
        }
        assert_true(cancelled_count > 2);
        mlrt_destroy_tree(tree);
    }
}

/* Rays that take long are not waited for: the host is asked within their item, not only behind it. */
static void items_that_take_long_look_up(void **state)
{
    (void)state;
    static float corners[STACKED_COUNT][9];
    static uint32_t totals[256];
    const mlrt_mesh mesh = stacked_triangles(corners);
    static float origins[256][3], directions[256][3];
    for (int i = 0; i < 256; ++i) {
        memcpy(origins[i], ((const float[3]){.5f + .001f * (float)(i % 16), .48f + .001f * (float)(i / 16), -3}), 12);
        /* a component below 2^-60: such rays are traced one by one in double */
        memcpy(directions[i], ((const float[3]){1e-25f * (float)(i % 13 + 1), 0, 1}), 12);
    }
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = 4, /* packets of 16 neighbours */
                            .count = 256,
                            .origins = {.data = origins},
                            .directions = {.data = directions}};
    const mlrt_hit_lists lists = {.struct_size = sizeof lists, .total = {.data = totals}};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {.data = totals}};
    mlrt_tree *tree = NULL;
    struct books books;
    open_books(&books);
    const mlrt_host host = {.struct_size = sizeof host, .user = &books, .progress = wait_and_take_progress};
    const mlrt_trace_options options = {.struct_size = sizeof options, .host = &host};
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    assert_int_equal(mlrt_trace_all_hits(tree, &rays, &options, &lists), MLRT_OK);
    assert_in_range(totals[0], STACKED_COUNT / 4, STACKED_COUNT);
    assert_in_range(books.tell_count, 60, 1000); /* after a few rays */
    books.tell_count = 0;
    assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
    assert_in_range(books.tell_count, 9, 1000); /* of 16 packets */
    mlrt_destroy_tree(tree);
}

/* ---- whose message is it? -------------------------------------------------------------------------------------- */

static void *run_with_message(void *argument)
{
    struct job *job = argument;
    mlrt_pool *pool;
    assert_int_equal(mlrt_create_pool(2000, &pool), MLRT_ERROR_ARGUMENT);
    char before[256];
    strcpy(before, mlrt_last_message());
    job->function(job->argument);
    assert_string_equal(mlrt_last_message(), before);
    return NULL;
}

static void *run_on_a_thread(void *user, mlrt_task_function function, void *argument)
{
    struct job job = {.function = function, .argument = argument};
    (void)user;
    assert_int_equal(pthread_create(&job.thread, NULL, run_with_message, &job), 0);
    pthread_join(job.thread, NULL);
    return NULL;
}

static void finish_nothing(void *user, void *task)
{
    (void)user;
    (void)task;
}

/* Frees a block, and fails a call. */
static void free_and_fail(void *user, void *block, size_t size, size_t alignment)
{
    mlrt_pool *pool;
    give_block(user, block, size, alignment);
    assert_int_equal(mlrt_create_pool(3000, &pool), MLRT_ERROR_ARGUMENT);
}

/* The message of a thread is about its own call, whoever does the work, and whatever the host does meanwhile. */
static void messages_stay_with_their_calls(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    static float corners[COUNT][9];
    uint32_t *indices = allocate_or_fail(3 * COUNT, sizeof *indices);
    for (uint32_t i = 0; i < 3 * COUNT; ++i) {
        corners[i / 3][3 * (i % 3)] = (float)(i * 31 % 1000);
        corners[i / 3][3 * (i % 3) + 1] = (float)(i * 17 % 997);
        indices[i] = i % 30000 == 0 ? 99999999 : i;
    }
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = corners,
                            .vertex_count = 3 * COUNT,
                            .indices = indices,
                            .triangle_count = COUNT};
    const char *const reason = "meshes[0], triangle 0: vertex index 99999999 is out of range (vertex_count is 300000)";
    const mlrt_pool_options with_threads = {
        .struct_size = sizeof with_threads, .thread_count = 3, .enqueue = run_on_a_thread, .finish = finish_nothing};
    mlrt_pool *pool;
    mlrt_tree *tree;
    assert_int_equal(mlrt_create_pool_with_options(&with_threads, &pool), MLRT_OK);
    mlrt_tree_options options = {.struct_size = sizeof options, .pool = pool};
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_ERROR_INDEX_RANGE);
    assert_string_equal(mlrt_last_message(), reason);
    mlrt_destroy_pool(pool);

    struct books books;
    char message[256];
    open_books(&books);
    mlrt_host host = host_with(&books);
    host.free = free_and_fail;
    options = (mlrt_tree_options){
        .struct_size = sizeof options, .host = &host, .message = message, .message_size = sizeof message};
    assert_int_equal(mlrt_build_tree(&mesh, 1, &options, &tree), MLRT_ERROR_INDEX_RANGE);
    assert_string_equal(message, reason);
    assert_string_equal(books.last_line, reason);
    assert_balanced(&books);
    free(indices);
}

/* A call without a place for what it makes says so as any other error is said. */
static void missing_results_are_told(void **state)
{
    (void)state;
    char message[256] = "old";
    struct books books;
    open_books(&books);
    const mlrt_host host = host_with(&books);
    const mlrt_tree_options options = {
        .struct_size = sizeof options, .host = &host, .message = message, .message_size = sizeof message};
    const mlrt_load_options load = {
        .struct_size = sizeof load, .host = &host, .message = message, .message_size = sizeof message};
    mlrt_tree *tree;
    assert_int_equal(mlrt_build_tree(NULL, 0, &options, NULL), MLRT_ERROR_ARGUMENT);
    assert_string_equal(message, "tree: NULL is not allowed");
    assert_string_equal(books.last_line, message);
    assert_int_equal(mlrt_estimate_tree(NULL, 0, &options, NULL), MLRT_ERROR_ARGUMENT);
    assert_string_equal(message, "estimate: NULL is not allowed");
    assert_int_equal(mlrt_load_tree(NULL, 0, &load, &tree), MLRT_ERROR_ARGUMENT);
    assert_string_equal(message, "data: NULL is not allowed");
    assert_int_equal(books.line_count[MLRT_LOG_ERROR], 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_memory_comes_from_the_host),
        cmocka_unit_test(memory_runs_out_anywhere),
        cmocka_unit_test(a_host_that_does_not_align_is_out_of_memory),
        cmocka_unit_test(both_functions_or_neither),
        cmocka_unit_test(sizes_are_those_of_the_books),
        cmocka_unit_test(estimates_need_no_meshes),
        cmocka_unit_test(a_limit_is_kept),
        cmocka_unit_test(a_limit_is_kept_for_few_triangles),
        cmocka_unit_test(the_log_tells_results_warnings_and_errors),
        cmocka_unit_test(messages_are_emptied),
        cmocka_unit_test(progress_ends_at_one),
        cmocka_unit_test(progress_of_no_rays_ends_at_one),
        cmocka_unit_test(calls_end_when_told_to),
        cmocka_unit_test(a_build_that_ends_stays_within_its_memory),
        cmocka_unit_test(a_tree_without_meshes_has_only_misses),
        cmocka_unit_test(one_thread_looks_up_from_large_sets),
        cmocka_unit_test(tasks_do_the_work_however_they_run),
        cmocka_unit_test(calls_within_jobs),
        cmocka_unit_test(progress_may_use_tasks),
        cmocka_unit_test(pool_options_are_checked),
        cmocka_unit_test(cancelled_calls_write_only_results),
        cmocka_unit_test(items_that_take_long_look_up),
        cmocka_unit_test(messages_stay_with_their_calls),
        cmocka_unit_test(missing_results_are_told),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
