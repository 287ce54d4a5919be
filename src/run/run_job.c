/* SPDX-License-Identifier: MIT */
/*
 * Runs a job: cuts the picture into tiles of initial_tile_size, the items that workers claim. A worker writes results
 * to the caller's frame and, for the callback, to a tile buffer of its own.
 */
#include "run/run_job.h"

#include <string.h>

#include "base/progress.h"
#include "base/scheduler.h"
#include "base/structs.h"
#include "hits/undecided.h"
#include "job/structure.h"
#include "job/sink.h"
#include "rays/rectangle.h"
#include "simd/sixteen.h"

struct run {
    const struct mlrt_job *job;
    struct mlrt_worker *workers;
    uint32_t column_count;
    struct mlrt_progress progress; /* by pixels */
};

/* Describes a traced tile to the callback: its place in the picture, and the arrays that were asked for. */
static void describe_tile(const struct mlrt_job *job, const struct mlrt_sink *sink, uint32_t worker_number,
                          const struct mlrt_rectangle *area, mlrt_tile *tile)
{
    *tile = (mlrt_tile){.struct_size = sizeof *tile,
                        .worker = worker_number,
                        .x = job->source.view.crop_x + area->x,
                        .y = job->source.view.crop_y + area->y,
                        .width = area->width,
                        .height = area->height,
                        .t = (const float *)(const void *)sink->channel[MLRT_CHANNEL_T].data,
                        .u = (const float *)(const void *)sink->channel[MLRT_CHANNEL_U].data,
                        .v = (const float *)(const void *)sink->channel[MLRT_CHANNEL_V].data,
                        .mesh = (const uint32_t *)(const void *)sink->channel[MLRT_CHANNEL_MESH].data,
                        .triangle = (const uint32_t *)(const void *)sink->channel[MLRT_CHANNEL_TRIANGLE].data,
                        .facing = (const int32_t *)(const void *)sink->channel[MLRT_CHANNEL_FACING].data,
                        .occluded = sink->channel[MLRT_CHANNEL_OCCLUDED].data};
}

/* Traces a tile to the frame and to the worker's tile buffer, whose rows are as wide as the tile. */
static MLRT_NOINLINE void trace_item(const struct run *run, struct mlrt_worker *worker,
                                     const struct mlrt_rectangle *area)
{
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c)
        worker->sinks.tile.channel[c].row_stride = area->width * worker->sinks.tile.channel[c].stride;
    mlrt_group_channels(&worker->sinks.tile);
    worker->sinks.tile.x = area->x;
    worker->sinks.tile.y = area->y;
    run->job->kernels->trace_area(run->job, worker, area);
}

static int32_t run_item(void *work, uint32_t item, uint32_t worker_number)
{
    struct run *run = work;
    const struct mlrt_job *job = run->job;
    struct mlrt_worker *worker = &run->workers[worker_number];
    const uint32_t size = job->initial_tile_size;
    const struct mlrt_rectangle whole = {0, 0, job->source.width, job->source.height};
    const struct mlrt_rectangle area =
        mlrt_cut_piece(&whole, item % run->column_count * size, item / run->column_count * size, size);

    worker->watch.pixels_told = 0;
    mlrt_enter_fp_environment(&worker->watch.environment);
    trace_item(run, worker, &area);
    mlrt_leave_fp_environment(&worker->watch.environment);
    if (worker->watch.stopped) return 1;
    if (job->callback.function) {
        mlrt_tile tile;
        describe_tile(job, &worker->sinks.tile, worker_number, &area, &tile);
        if (job->callback.function(job->callback.user, &tile) != 0) return 1;
    }
    return mlrt_advance(&run->progress, (double)area.width * area.height - worker->watch.pixels_told);
}

/* 1 if the callback gets this channel. */
static int wants_channel(const struct mlrt_job *job, enum mlrt_channel channel)
{
    static const uint32_t output[MLRT_CHANNEL_COUNT] = {
        MLRT_OUTPUT_T,     MLRT_OUTPUT_UV, MLRT_OUTPUT_UV, MLRT_OUTPUT_IDS, MLRT_OUTPUT_IDS | MLRT_OUTPUT_TRIANGLE,
        MLRT_OUTPUT_FACING};
    if (!job->callback.function) return 0;
    if (channel == MLRT_CHANNEL_OCCLUDED && job->light_count)
        return (job->callback.outputs & MLRT_OUTPUT_OCCLUDED) != 0;
    return job->any ? channel == MLRT_CHANNEL_OCCLUDED : (job->callback.outputs & output[channel]) != 0;
}

/* The logarithm of how many known planes a worker keeps. */
static uint32_t known_plane_bits(const struct mlrt_job *job)
{
    return mlrt_is_small(job) ? MLRT_FEW_PLANE_BITS : MLRT_KNOWN_PLANE_BITS;
}

/*
 * Lays out a worker's share of memory, from `memory` on: its tables and its tile buffer. Returns its bytes. With NULL,
 * only returns them.
 */
static size_t lay_out_share(const struct mlrt_job *job, unsigned char *memory, struct mlrt_worker *worker)
{
    const size_t pixel_count = (size_t)job->initial_tile_size * job->initial_tile_size;
    size_t size = job->tree->structure->tracer.lay_out(job, memory, worker);
    if (memory) worker->known.planes = (struct mlrt_known_plane *)(void *)(memory + size);
    size += sizeof(struct mlrt_known_plane) << known_plane_bits(job);
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        const size_t element_size = mlrt_channel_size((enum mlrt_channel)c);
        if (!wants_channel(job, (enum mlrt_channel)c)) continue;
        if (memory) worker->sinks.tile.channel[c] = (struct mlrt_image){memory + size, element_size, 0};
        size += pixel_count * element_size;
    }
    return (size + 63) / 64 * 64;
}

static void begin_worker(const struct mlrt_job *job, unsigned char *share, struct mlrt_worker *worker)
{
    memset(&worker->counters, 0, sizeof worker->counters);
    memset(&worker->sinks.tile, 0, sizeof worker->sinks.tile);
    (void)lay_out_share(job, share, worker);
    worker->sinks.count = 0;
    if (!mlrt_sink_is_empty(&job->frame)) worker->sinks.each[worker->sinks.count++] = &job->frame;
    if (job->callback.function) worker->sinks.each[worker->sinks.count++] = &worker->sinks.tile;
    mlrt_forget_planes(known_plane_bits(job), worker);
    mlrt_fill_words(worker->hit_terms.numbers, MLRT_NONE);
    worker->mask = job->source.common_mask;
    worker->mesh = 0;
    worker->watch.progress = NULL;
    worker->watch.slow_steps = 0;
    worker->lone = NULL;
    worker->scaled = NULL;
    worker->watch.stopped = 0;
}

static int32_t run_items(const struct mlrt_run_options *options, uint32_t item_count, uint32_t worker_count,
                         struct run *run)
{
    mlrt_begin_progress(&options->voice.host, (double)run->job->source.width * run->job->source.height, &run->progress);
    for (uint32_t w = 0; options->voice.host.progress && w < worker_count; ++w)
        run->workers[w].watch.progress = &run->progress;
    const int32_t answer = mlrt_run_items(options->pool, item_count, run_item, run);
    for (uint32_t w = 0; options->counters && w < worker_count; ++w)
        mlrt_add_counters(options->counters, &run->workers[w].counters);
    return mlrt_end_progress(&run->progress, answer ? MLRT_ERROR_CANCELLED : MLRT_OK);
}

/* Memory for one worker of a call whose rays are one block, or none: it is on the stack of the caller. */
struct block_worker {
    struct mlrt_worker worker;
    MLRT_ALIGNED(64) unsigned char share[1024];
};

static MLRT_NOINLINE int32_t run_block(const struct mlrt_job *job, uint32_t item_count,
                                       const struct mlrt_run_options *options)
{
    struct block_worker own;
    struct run run = {.job = job, .workers = &own.worker, .column_count = 1};
    begin_worker(job, own.share, &own.worker);
    return run_items(options, item_count, 1, &run);
}

int32_t mlrt_run_job(struct mlrt_job *job, const struct mlrt_run_options *options)
{
    mlrt_group_channels(&job->frame);
    const uint32_t columns = mlrt_item_count(job->source.width, job->initial_tile_size);
    const uint64_t item_count = (uint64_t)columns * mlrt_item_count(job->source.height, job->initial_tile_size);
    const size_t share = lay_out_share(job, NULL, NULL);
    if (mlrt_is_block(job) && item_count <= 1 && share <= sizeof((struct block_worker *)NULL)->share)
        return run_block(job, (uint32_t)item_count, options);
    const uint32_t worker_count = item_count <= 1 ? 1 : mlrt_worker_count(options->pool);
    struct mlrt_memory memory = mlrt_host_memory(&options->voice.host, 0);
    struct run run = {.job = job, .column_count = columns};
    run.workers = mlrt_allocate(&memory, worker_count, sizeof *run.workers + share);
    if (!run.workers) return MLRT_ERROR_OUT_OF_MEMORY;
    unsigned char *shares = (unsigned char *)(run.workers + worker_count);
    for (uint32_t w = 0; w < worker_count; ++w) begin_worker(job, shares + w * share, &run.workers[w]);
    const int32_t status = run_items(options, (uint32_t)item_count, worker_count, &run);
    mlrt_free(&memory, run.workers, worker_count, sizeof *run.workers + share);
    return status;
}
