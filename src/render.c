/* SPDX-License-Identifier: MIT */
/*
 * From a job to its results: the picture is cut into tiles of initial_tile_size, which workers trace one by one, each
 * into the caller's frame and into its own tile buffer for the callback.
 */
#include "render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "counters.h"
#include "scheduler.h"

struct run {
    const struct mlrt_job *job;
    struct mlrt_worker *workers;
    uint32_t column_count;
};

static uint32_t tile_count(uint32_t length, uint32_t size)
{
    return length / size + (length % size != 0);
}

/* The tile for the callback: the arrays that it asked for, over a tile of this width. */
static void describe_tile(const struct mlrt_job *job, const struct mlrt_worker *worker, uint32_t number, uint32_t width,
                          uint32_t height, mlrt_tile *tile)
{
    const struct mlrt_sink *sink = &worker->tile;
    *tile = (mlrt_tile){sizeof *tile,
                        number,
                        job->source.view.first_x + worker->tile_x,
                        job->source.view.first_y + worker->tile_y,
                        width,
                        height,
                        (const float *)(const void *)sink->channel[MLRT_CHANNEL_T].data,
                        (const float *)(const void *)sink->channel[MLRT_CHANNEL_U].data,
                        (const float *)(const void *)sink->channel[MLRT_CHANNEL_V].data,
                        (const uint32_t *)(const void *)sink->channel[MLRT_CHANNEL_MESH].data,
                        (const uint32_t *)(const void *)sink->channel[MLRT_CHANNEL_TRIANGLE].data,
                        (const int32_t *)(const void *)sink->channel[MLRT_CHANNEL_FACING].data,
                        sink->channel[MLRT_CHANNEL_OCCLUDED].data};
}

static MLRT_NOINLINE void trace_item(const struct run *run, struct mlrt_worker *worker, uint32_t x, uint32_t y,
                                     uint32_t width, uint32_t height)
{
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        worker->tile.channel[c].row_stride = width * worker->tile.channel[c].stride;
    }
    worker->tile_x = x;
    worker->tile_y = y;
    run->job->kernels->trace_tile(run->job, worker, x, y, width, height);
}

static int32_t run_item(void *work, uint32_t item, uint32_t number)
{
    const struct run *run = work;
    const struct mlrt_job *job = run->job;
    struct mlrt_worker *worker = &run->workers[number];
    const uint32_t size = job->initial_tile_size;
    const uint32_t x = item % run->column_count * size, y = item / run->column_count * size;
    const uint32_t width = job->source.width - x < size ? job->source.width - x : size;
    const uint32_t height = job->source.height - y < size ? job->source.height - y : size;

    const uint64_t environment = mlrt_enter_fp_environment();
    trace_item(run, worker, x, y, width, height);
    mlrt_leave_fp_environment(environment);
    if (!job->callback) return 0;
    mlrt_tile tile;
    describe_tile(job, worker, number, width, height, &tile);
    return job->callback(job->user, &tile);
}

static int wants_channel(const struct mlrt_job *job, enum mlrt_channel channel)
{
    static const uint32_t output[MLRT_CHANNEL_COUNT] = {
        MLRT_OUTPUT_T,     MLRT_OUTPUT_UV, MLRT_OUTPUT_UV, MLRT_OUTPUT_IDS, MLRT_OUTPUT_IDS | MLRT_OUTPUT_TRIANGLE,
        MLRT_OUTPUT_FACING};
    if (!job->callback) return 0;
    return job->any ? channel == MLRT_CHANNEL_OCCLUDED : (job->outputs & output[channel]) != 0;
}

/* Buffers for the tiles of all workers, in one block; NULL if there is no memory. */
static unsigned char *make_tile_buffers(const struct mlrt_job *job, uint32_t worker_count, struct mlrt_worker *workers)
{
    const size_t pixel_count = (size_t)job->initial_tile_size * job->initial_tile_size;
    size_t worker_size = 0;
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        if (wants_channel(job, (enum mlrt_channel)c))
            worker_size += pixel_count * mlrt_channel_size((enum mlrt_channel)c);
    }
    if (worker_size > (SIZE_MAX - 1) / worker_count) return NULL;
    unsigned char *buffers = malloc(worker_size * worker_count + 1);
    if (!buffers) return NULL;
    unsigned char *next = buffers;
    for (uint32_t w = 0; w < worker_count; ++w) {
        for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
            if (!wants_channel(job, (enum mlrt_channel)c)) continue;
            workers[w].tile.channel[c].data = next;
            workers[w].tile.channel[c].stride = mlrt_channel_size((enum mlrt_channel)c);
            next += pixel_count * mlrt_channel_size((enum mlrt_channel)c);
        }
    }
    return buffers;
}

/* A call of few rays should not pay for clearing tables: an apex that no ray has says that they are empty. */
static void begin_worker(const struct mlrt_job *job, struct mlrt_worker *worker)
{
    memset(&worker->counters, 0, sizeof worker->counters);
    memset(worker->pairs, 0, sizeof worker->pairs);
    memset(&worker->tile, 0, sizeof worker->tile);
    /* Of the methods of the kd-tree only multilevel shares set-up triangles among packets. */
    worker->setup_mask = job->shared_setups ? MLRT_SETUP_COUNT - 1 : 0;
    for (int k = 0; k < 3; ++k) worker->apex[k] = worker->leaf_apex[k] = NAN;
    worker->open_tiles = worker->open_squares = worker->mesh = 0;
}

int32_t mlrt_run_job(const struct mlrt_job *job, mlrt_pool *pool, mlrt_counters *counters)
{
    const uint32_t columns = tile_count(job->source.width, job->initial_tile_size);
    const uint64_t item_count = (uint64_t)columns * tile_count(job->source.height, job->initial_tile_size);
    if (item_count == 0) return MLRT_OK;

    const uint32_t worker_count = mlrt_worker_count(pool);
    struct mlrt_memory memory = {0, 0, 0};
    struct mlrt_worker *workers = mlrt_allocate(&memory, worker_count, sizeof *workers);
    if (!workers) return MLRT_ERROR_OUT_OF_MEMORY;
    for (uint32_t w = 0; w < worker_count; ++w) begin_worker(job, &workers[w]);
    unsigned char *buffers = make_tile_buffers(job, worker_count, workers);
    if (!buffers) {
        mlrt_free(&memory, workers, worker_count, sizeof *workers);
        return MLRT_ERROR_OUT_OF_MEMORY;
    }
    struct run run = {job, workers, columns};
    const int32_t answer = mlrt_run_items(pool, (uint32_t)item_count, run_item, &run);
    if (counters) {
        for (uint32_t w = 0; w < worker_count; ++w) mlrt_add_counters(counters, &workers[w].counters);
    }
    free(buffers);
    mlrt_free(&memory, workers, worker_count, sizeof *workers);
    return answer ? MLRT_ERROR_CANCELLED : MLRT_OK;
}
