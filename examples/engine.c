/* SPDX-License-Identifier: MIT */
/*
 * engine.c - the loop of a small game engine around the library: its own memory, its own jobs, its own log
 *
 * It shows how to embed the library: main passes the engine's hooks to it; load builds a tree with a progress display,
 * a memory budget and a way to cancel; draw_frame puts jobs of the engine and tasks of the library into one queue,
 * rebuilds a tree in a job, and renders the picture by tiles. engine/draw.c is the tile callback: bodies with trees of
 * their own, shadows, colours. The pictures have the same bits for any number of workers (picture_hash).
 */
#include "common/hash.h"
#include "common/options.h"
#include "common/png_write.h"
#include "common/report.h"
#include "common/timer.h"
#include "common/view.h"
#include "engine/draw.h"
#include "engine/jobs.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct engine {
    const char *output;
    uint32_t size[2], worker_count, frame_count, budget;
    double cancel_at;
    FILE *log; // the engine's own, not the library's business
    struct heap heap;
    mlrt_host host;
    struct jobs *jobs;
    mlrt_pool *pool;
    struct world world;
    mlrt_camera camera;
    struct drawing drawing;
    uint32_t picked;
    double told;  // progress in the log
    double time;  // of the world, in seconds
    int32_t bent; // status of the job that deforms
    uint64_t hash;
    size_t stack_peak_size;
};

/* ---- log ----------------------------------------------------------------------------------------------------- */

static void say(struct engine *engine, const char *who, const char *format, ...)
{
    va_list values;
    if (!engine->log) return;
    fprintf(engine->log, "%-7s", who);
    va_start(values, format);
    vfprintf(engine->log, format, values);
    va_end(values);
    fputc('\n', engine->log);
}

// What the library has to say comes from the thread of the call, one line at a time.
static void on_log(void *user, int32_t level, const char *message)
{
    static const char *const names[] = {"error: ", "warning: ", ""};
    say(user, "mlrt", "%s%s", level >= MLRT_LOG_ERROR && level <= MLRT_LOG_INFO ? names[level] : "", message);
}

/* ---- load ---------------------------------------------------------------------------------------------------- */

// May come from any worker, but from one at a time. It should be quick: the build waits for it.
static int32_t on_progress(void *user, double fraction)
{
    struct engine *engine = user;
    const int tenth = (int)(10 * fraction);
    if (tenth > engine->told) {
        engine->told = tenth;
        say(engine, "load", "[%.*s%.*s] %d %%", tenth, "##########", 10 - tenth, "..........", 10 * tenth);
    }
    return fraction >= engine->cancel_at;
}

// The room: large, so with all workers, within a budget, with progress. The bulb is seen, but it shades nothing.
static int32_t load(struct engine *engine)
{
    struct world *world = &engine->world;
    const struct scene *parts[2] = {&world->room, &world->bulb};
    mlrt_mesh meshes[2];
    memset(meshes, 0, sizeof meshes);
    for (uint32_t i = 0; i < 2; i++) {
        meshes[i].struct_size = sizeof meshes[i];
        meshes[i].id = i == 0 ? MESH_ROOM : MESH_BULB;
        meshes[i].mask = i == 0 ? SEEN_BY_ALL : SEEN_BY_CAMERA;
        meshes[i].vertices = parts[i]->vertices;
        meshes[i].vertex_count = parts[i]->vertex_count;
        meshes[i].indices = parts[i]->indices;
        meshes[i].triangle_count = parts[i]->triangle_count;
    }
    // The bar is this call's alone. The tree keeps the heap of the host, but neither its log nor its progress.
    mlrt_host host = engine->host;
    host.progress = on_progress;
    mlrt_tree_options options = {.struct_size = sizeof options,
                                 .pool = engine->pool,
                                 .host = &host,
                                 .memory_limit = (uint64_t)engine->budget << 20};
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    const int32_t status = mlrt_estimate_tree(meshes, 2, &options, &estimate);
    if (status != MLRT_OK) return status;
    say(engine, "load", "will take %.1f MB, %.1f MB meanwhile, of %u MB", 1e-6 * (double)estimate.memory_size,
        1e-6 * (double)estimate.peak_memory_size, (unsigned)engine->budget);
    return mlrt_build_tree(meshes, 2, &options, &world->tree);
}

/* ---- frames -------------------------------------------------------------------------------------------------- */

static void deform(void *argument)
{
    struct engine *engine = argument;
    engine->bent = world_deform(&engine->world, engine->time);
}

// Everything in one queue: while a worker deforms the blob and builds its tree, this one moves what is rigid. Then the
// library's tiles go through the same queue.
static int32_t draw_frame(struct engine *engine, uint32_t frame)
{
    engine->time = 0.125 * frame;
    void *job = jobs_add(engine->jobs, deform, engine);
    world_move(&engine->world, engine->time, engine->picked);
    jobs_wait(engine->jobs, job);
    if (engine->bent != MLRT_OK) return engine->bent;

    const mlrt_trace_options options = {.struct_size = sizeof options,
                                        .initial_tile_size = TILE_SIZE,
                                        .outputs = TILE_OUTPUTS,
                                        .mask = SEEN_BY_CAMERA,
                                        .pool = engine->pool,
                                        .host = &engine->host};
    const int32_t status =
        mlrt_render_tiles(engine->world.tree, &engine->camera, &options, NULL, draw_tile, &engine->drawing);
    // The mouse wanders from left to right through the middle of the picture.
    const float x = (float)engine->size[0] * (0.35f + 0.04f * (float)(frame % 8)), y = 0.42f * (float)engine->size[1];
    if (status == MLRT_OK) engine->picked = pick(&engine->world, &engine->camera, x, y);
    return status;
}

static int32_t draw_frames(struct engine *engine)
{
    const size_t size = 3 * (size_t)engine->size[0] * engine->size[1];
    int32_t status = MLRT_OK;
    engine->hash = HASH_START;
    for (uint32_t frame = 0; frame < engine->frame_count && status == MLRT_OK; frame++) {
        const uint64_t before = engine->heap.system_call_count;
        const double start = seconds_now();
        status = draw_frame(engine, frame);
        if (status != MLRT_OK) break;
        const uint32_t picked = engine->picked;
        printf("frame_%u_milliseconds %.2f\n", (unsigned)frame, 1e3 * (seconds_now() - start));
        engine->hash = hash_uint32(engine->hash, picked);
        for (size_t i = 0; i < size; i++) engine->hash = hash_byte(engine->hash, engine->drawing.rgb[i]);
        say(engine, "engine", "frame %u: mouse over %s, %u blocks from the system", (unsigned)frame,
            picked == BODY_COUNT ? "the room" : engine->world.bodies[picked].name,
            (unsigned)(engine->heap.system_call_count - before));
    }
    return status;
}

/* ---- from the start to the end ------------------------------------------------------------------------------- */

static int32_t run(struct engine *engine)
{
    const mlrt_pool_options hooks = {.struct_size = sizeof hooks,
                                     .thread_count = engine->worker_count,
                                     .host = &engine->host,
                                     .user = engine->jobs,
                                     .enqueue = jobs_add,
                                     .finish = jobs_wait};
    struct drawing *drawing = &engine->drawing;
    int32_t status = mlrt_create_pool_with_options(&hooks, &engine->pool);
    if (status == MLRT_OK) status = world_begin(&engine->world, &engine->host);
    if (status == MLRT_OK) status = load(engine);
    if (status != MLRT_OK) return status;
    heap_trim(&engine->heap); // what the build has needed
    const size_t size = 3 * (size_t)engine->size[0] * engine->size[1];
    if (camera_of_view(&engine->world.room.view, engine->size[0], engine->size[1], &engine->camera))
        return MLRT_ERROR_CAMERA;
    drawing->world = &engine->world;
    drawing->camera = &engine->camera;
    drawing->worker_count = engine->worker_count;
    drawing->heap = &engine->heap;
    if (!(drawing->rgb = heap_allocate(&engine->heap, size, 64))) return MLRT_ERROR_OUT_OF_MEMORY;
    status = drawing_begin(drawing);
    if (status == MLRT_OK) status = draw_frames(engine);
    if (status == MLRT_OK && engine->output &&
        write_png(engine->output, engine->size[0], engine->size[1], drawing->rgb))
        status = MLRT_ERROR_ARGUMENT;
    return status;
}

static void stop(struct engine *engine)
{
    for (uint32_t i = 0; engine->drawing.workers && i < engine->worker_count; i++) {
        const size_t size = engine->drawing.workers[i].stack.peak_size;
        if (size > engine->stack_peak_size) engine->stack_peak_size = size;
    }
    drawing_end(&engine->drawing);
    if (engine->drawing.rgb)
        heap_free(&engine->heap, engine->drawing.rgb, 3 * (size_t)engine->size[0] * engine->size[1], 64);
    world_end(&engine->world);
    mlrt_destroy_pool(engine->pool);
    jobs_end(engine->jobs, &engine->heap);
}

static void *engine_allocate(void *engine, size_t size, size_t alignment)
{
    return heap_allocate(&((struct engine *)engine)->heap, size, alignment);
}

static void engine_free(void *engine, void *block, size_t size, size_t alignment)
{
    heap_free(&((struct engine *)engine)->heap, block, size, alignment);
}

int main(int argc, char **argv)
{
    static struct engine engine = {
        .size = {640, 360}, .worker_count = 2, .frame_count = 8, .budget = 256, .cancel_at = 2, .picked = BODY_COUNT};
    int quiet = 0, exit_code;
    const struct option options[] = {
        {OPTION_COUNT, "--frames", &engine.frame_count, "N", "frames to draw (default: 8)", 1, 100000},
        {OPTION_SIZE, "--size", engine.size, "WxH", "pixels (default: 640x360)", 1, 8192},
        {OPTION_COUNT, "--workers", &engine.worker_count, "N", "threads of the job system (default: 2)", 1, 64},
        {OPTION_COUNT, "--budget", &engine.budget, "MB", "memory that the load may hold (default: 256)", 1, 65536},
        {OPTION_NUMBER, "--cancel-at", &engine.cancel_at, "X", "stop loading at this share of it, 0..1", 0, 0},
        {OPTION_FLAG, "--quiet", &quiet, NULL, "no log on stderr", 0, 0},
        {OPTION_TEXT, "-o", &engine.output, "FILE.png", "where the last frame goes", 0, 0},
    };
    if (!parse_options("engine - a game engine's loop around the library", options, sizeof options / sizeof *options,
                       argc, argv, &exit_code))
        return exit_code;
    if (engine.output && check_png_name(engine.output)) return 2;
    engine.log = quiet ? NULL : stderr;
    engine.host = (mlrt_host){sizeof engine.host, 0, &engine, engine_allocate, engine_free, on_log, NULL};
    heap_begin(&engine.heap);
    engine.jobs = jobs_begin(&engine.heap, engine.worker_count);
    const int32_t status = engine.jobs ? run(&engine) : MLRT_ERROR_OUT_OF_MEMORY;
    stop(&engine);
    printf("status %s\n", mlrt_status_string(status));
    if (status == MLRT_OK) print_hash("picture_hash", engine.hash);
    print_count("stack_peak_size", engine.stack_peak_size); // of any worker, for calls from within the callback
    print_count("heap_peak_size", engine.heap.peak_size);
    print_count("heap_held_size", engine.heap.held_size); // 0, also after an error or a cancelled load
    const int leaks = engine.heap.held_size != 0;
    heap_end(&engine.heap);
    return end_output(leaks || (status != MLRT_OK && status != MLRT_ERROR_CANCELLED));
}
