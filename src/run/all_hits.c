/* SPDX-License-Identifier: MIT */
/* All hits of rays: one ray after the other. Workers claim pieces of ITEM_RAYS rays. */
#include "run/run_job.h"

#include <string.h>

#include "base/progress.h"
#include "base/host.h"
#include "base/scheduler.h"
#include "base/structs.h"
#include "exact/hit_list.h"
#include "job/structure.h"
#include "job/set_hit.h"
#include "job/sink.h"

#define ITEM_RAYS 256

/* After so many hits the host is asked in the middle of an item, too. */
#define MANY_HITS 1000

struct worker {
    struct mlrt_hit_list list;
    mlrt_counters counters;
};

struct run {
    const struct mlrt_tree *tree;
    const struct mlrt_source *source;
    const mlrt_hit_lists *lists;
    mlrt_hits hits;    /* the arrays of hits, `crossing` in place of `occluded` */
    uint32_t numbers;  /* what has to be computed for each hit: MLRT_OUTPUT_* */
    uint32_t capacity; /* places of a ray in the arrays; 0 without arrays, and then no hits are put in order */
    int counting;
    struct worker *workers;
    struct mlrt_progress progress; /* by rays */
};

static void set_arrays(const mlrt_hit_lists *lists, struct run *run)
{
    struct mlrt_sink sink;
    run->hits = (mlrt_hits){.t = lists->t,
                            .u = lists->u,
                            .v = lists->v,
                            .mesh = lists->mesh,
                            .triangle = lists->triangle,
                            .facing = lists->facing,
                            .occluded = lists->crossing};
    mlrt_make_sink(&run->hits, 1, 1, &sink);
    mlrt_group_channels(&sink);
    run->numbers = sink.numbers;
    run->capacity = mlrt_sink_is_empty(&sink) ? 0 : lists->capacity;
}

static void write_count(const mlrt_array *array, size_t i, uint32_t count)
{
    const size_t stride = array->stride ? array->stride : sizeof count;
    if (array->data) memcpy((unsigned char *)array->data + i * stride, &count, sizeof count);
}

static int crosses(const struct run *run, const struct mlrt_ray_segment *ray, uint32_t number)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&run->tree->by_number, number);
    return mlrt_crosses_triangle(ray, &triangle);
}

static uint32_t count_crossings(const struct run *run, const struct mlrt_ray_segment *ray,
                                const struct mlrt_hit_list *list)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < list->count; ++i) count += (uint32_t)crosses(run, ray, list->hits[i].triangle);
    return count;
}

/* Reads ray i, gathers its hits and writes them. Returns 0 if there was no memory. */
static int trace_ray(const struct run *run, struct worker *worker, uint32_t i)
{
    struct mlrt_hit_list *list = &worker->list;
    mlrt_counters *counters = run->counting ? &worker->counters : NULL;
    struct mlrt_ray_segment ray;
    uint32_t skip;
    list->count = 0;
    ++worker->counters.ray_count;
    if (mlrt_get_ray(run->source, i, &ray, &skip)) {
        ++worker->counters.packet_count;
        (void)run->tree->structure->tracer.trace_ray(run->tree, &ray, skip, 0, list, counters);
        mlrt_remove_repetitions(list);
        mlrt_order_hits(&run->tree->by_number, &ray, run->capacity, list, counters);
    }
    if (list->failed) return 0;
    write_count(&run->lists->total, i, list->count);
    if (run->lists->crossing_total.data) write_count(&run->lists->crossing_total, i, count_crossings(run, &ray, list));
    for (uint32_t j = 0; j < run->capacity; ++j) {
        const uint32_t number = j < list->count ? list->hits[j].triangle : MLRT_NONE;
        mlrt_hit hit;
        mlrt_set_hit(run->tree, &ray, number, run->numbers, &hit);
        hit.occluded = number != MLRT_NONE && run->lists->crossing.data && crosses(run, &ray, number);
        mlrt_write_hits(&hit, (size_t)i * run->capacity + j, 1, &run->hits);
    }
    return 1;
}

/* Traces rays of an item until the host has to be asked. Returns how many; 0 if there was no memory. */
static MLRT_NOINLINE uint32_t trace_rays(const struct run *run, struct worker *worker, uint32_t first, uint32_t count)
{
    uint32_t traced = 0;
    for (size_t hit_count = 0; traced < count && hit_count < MANY_HITS; hit_count += worker->list.count)
        if (!trace_ray(run, worker, first + traced++)) return 0;
    return traced;
}

static int32_t run_item(void *work, uint32_t item, uint32_t worker_number)
{
    struct run *run = work;
    const uint32_t begin = item * ITEM_RAYS, count = mlrt_item_size(run->source->count, ITEM_RAYS, item);
    for (uint32_t i = 0, traced; i < count; i += traced) {
        MLRT_COMPUTE(traced = trace_rays(run, &run->workers[worker_number], begin + i, count - i));
        if (!traced) return MLRT_ERROR_OUT_OF_MEMORY;
        if (mlrt_advance(&run->progress, traced)) return MLRT_ERROR_CANCELLED;
    }
    return MLRT_OK;
}

int32_t mlrt_run_all_hits(const struct mlrt_tree *tree, const struct mlrt_source *source, const mlrt_hit_lists *lists,
                          const struct mlrt_run_options *options)
{
    struct run run = {.tree = tree, .source = source, .lists = lists, .counting = options->counters != NULL};
    set_arrays(lists, &run);
    const uint32_t worker_count = mlrt_worker_count(options->pool);
    const uint32_t item_count = mlrt_item_count(source->count, ITEM_RAYS);
    struct mlrt_memory memory = mlrt_host_memory(&options->voice.host, 0);
    run.workers = mlrt_allocate_zeroed(&memory, worker_count, sizeof *run.workers);
    if (!run.workers) return MLRT_ERROR_OUT_OF_MEMORY;
    for (uint32_t w = 0; w < worker_count; ++w) run.workers[w].list.memory = memory;
    mlrt_begin_progress(&options->voice.host, (double)source->count, &run.progress);
    const int32_t status = mlrt_run_items(options->pool, item_count, run_item, &run);
    for (uint32_t w = 0; w < worker_count; ++w) {
        if (options->counters) mlrt_add_counters(options->counters, &run.workers[w].counters);
        mlrt_free_hit_list(&run.workers[w].list);
    }
    mlrt_free(&memory, run.workers, worker_count, sizeof *run.workers);
    return mlrt_end_progress(&run.progress, status);
}
