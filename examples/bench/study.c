/* SPDX-License-Identifier: MIT */
/* study.c - sweeps and builds: see study.h */
#include "study.h"

#include "calls.h"
#include "cost_study.h"

#include "common/must.h"
#include "common/timer.h"
#include "common/tree.h"

#include <stdio.h>

enum { SMALLEST_SIZE = 256 };

uint32_t default_kinds(int32_t study)
{
    if (study == STUDY_TRIANGLES) return 1u << PRIMARY | 1u << BOUNCE;
    if (study == STUDY_RESOLUTION) return 1u << FRAME;
    if (study == STUDY_COSTS) return 1u << FRAME | 1u << ARRAY | 1u << SHADOW | 1u << BOUNCE | 1u << SINGLE;
    return (1u << KIND_COUNT) - 1;
}

/* ---- sweeps -------------------------------------------------------------------------------------------------- */

static int measure_point(const struct bench_settings *settings, const struct arena *arena, uint32_t size,
                         enum kind kind)
{
    struct contest contest;
    struct task task;
    const int failed = start_contest(settings, arena, kind, &task, &contest) || hold_contest(&contest);
    for (size_t i = 0; i < contest.count && !failed; i++) {
        const struct contender *c = &contest.contenders[i];
        if (c->who != LIBRARY || c->unsupported) continue;
        print_csv_line(&contest, c);
        printf(",%zu,%lu", arena->subject.scene.triangle_count, (unsigned long)size);
        end_csv_line(&contest, c);
    }
    fflush(stdout);
    free_task(&task);
    return failed;
}

// Pictures of the smallest to the largest size, twice as wide each time.
static int sweep_sizes(const struct bench_settings *settings, const char *word, uint32_t smallest, uint32_t largest)
{
    struct arena arena;
    int failed = open_arena(settings, word, &arena);
    for (uint32_t size = smallest; size <= largest && !failed; size *= 2) {
        failed = set_size(&arena.subject, size);
        for (int kind = 0; kind < KIND_COUNT && !failed; kind++) {
            if (settings->kinds & 1u << kind) failed = measure_point(settings, &arena, size, (enum kind)kind);
        }
    }
    close_arena(&arena);
    return failed;
}

static int study_sweep(const struct bench_settings *settings, const struct word_list *scenes, uint32_t smallest)
{
    int failed = 0;
    fputs("scene,kind,method,isa,threads,mrays,embree_fast_mrays,embree_robust_mrays,triangles,size", stdout);
    end_csv_head(settings);
    for (size_t i = 0; i < scenes->count; i++) {
        failed |= sweep_sizes(settings, scenes->words[i], smallest, settings->size);
    }
    return failed;
}

static int study_triangles(const struct bench_settings *settings)
{
    static const struct word_list by_count = {
        19,
        {"sphere:80", "sphere:320", "sphere:1280", "sphere:5120", "sphere:20480", "sphere:81920", "sphere:327680",
         "sphere:1310720", "sphere:5242880", "scan:1000", "scan:3000", "scan:10000", "scan:30000", "scan:100000",
         "scan:300000", "scan:1000000", "scan:2000000", "scan:4000000", "scan:8000000"}};
    return study_sweep(settings, settings->scenes.count ? &settings->scenes : &by_count, settings->size);
}

/* ---- building ------------------------------------------------------------------------------------------------ */

enum { KDTREE_BUILDER_COUNT = 2, BUILDER_COUNT = 9 };

static const struct builder {
    const char *name;
    int32_t kind; // TREE_*, or Embree's quality
    int is_peer, robust;
} builders[BUILDER_COUNT] = {
    {"mlrt_kdtree", TREE_KDTREE, 0, 0},
    {"mlrt_kdtree_tuned", TREE_KDTREE_TUNED, 0, 0},
    {"mlrt_fast", TREE_FAST, 0, 0},
    {"mlrt", TREE_DEFAULT, 0, 0},
    {"mlrt_best", TREE_BEST, 0, 0},
    {"embree_fast_medium", PEER_MEDIUM_QUALITY, 1, 0},
    {"embree_fast_high", PEER_HIGH_QUALITY, 1, 0},
    {"embree_robust_medium", PEER_MEDIUM_QUALITY, 1, 1},
    {"embree_robust_high", PEER_HIGH_QUALITY, 1, 1},
};

struct built {
    int unsupported;
    double elapsed[MAXIMUM_RUNS], processor[MAXIMUM_RUNS]; // seconds
    double memory_size;
};

static int build_with_mlrt(const struct builder *builder, const struct scene *scene, mlrt_pool *pool,
                           struct built *built, struct span *time)
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    mlrt_tree *tree;
    const int32_t status = build_mlrt(&this_library, scene, builder->kind, pool, &tree, time);
    if (status == MLRT_OK && mlrt_get_tree_info(tree, &info) == MLRT_OK) built->memory_size = (double)info.memory_size;
    mlrt_destroy_tree(tree);
    if (status == MLRT_OK) return 0;
    fprintf(stderr, "%s: %s\n", builder->name, mlrt_status_string(status));
    return 1;
}

static int build_with_peer(const struct builder *builder, const struct scene *scene, uint32_t threads,
                           struct built *built, struct span *time)
{
    const struct peer_settings settings = {builder->robust, builder->kind, threads, PEER_ISA_AUTO};
    struct peer_build build = {{0, 0}, 0};
    built->unsupported = !have_peer();
    if (built->unsupported) return 0;
    struct peer *peer = create_peer(scene, &settings, &build);
    *time = build.time;
    built->memory_size = (double)build.memory_size;
    destroy_peer(peer);
    rest(); // or its threads, which end now, would take processor time from the next builder
    return peer == NULL;
}

static void print_builds(const struct bench_settings *settings, const struct subject *subject, struct built *built)
{
    for (int i = 0; i < BUILDER_COUNT; i++) {
        if (built[i].unsupported) continue;
        printf("%s,%zu,%s,%u,%.5f,%.5f,%.1f\n", subject->name, subject->scene.triangle_count, builders[i].name,
               (unsigned)settings->threads, median(built[i].elapsed, settings->runs),
               median(built[i].processor, settings->runs),
               built[i].memory_size / (double)subject->scene.triangle_count);
    }
    fflush(stdout);
}

// Builders first .. end - 1 take turns.
static int take_turns(const struct bench_settings *settings, mlrt_pool *pool, const struct scene *scene, uint32_t first,
                      uint32_t end, struct built *built)
{
    int failed = 0;
    for (uint32_t turn = 0; turn < settings->runs * (end - first) && !failed; turn++) {
        const uint32_t number = first + turn % (end - first), run = turn / (end - first);
        struct span time = {0, 0};
        if (built[number].unsupported) continue;
        failed = builders[number].is_peer
                     ? build_with_peer(&builders[number], scene, settings->threads, &built[number], &time)
                     : build_with_mlrt(&builders[number], scene, pool, &built[number], &time);
        built[number].elapsed[run] = time.elapsed;
        built[number].processor[run] = time.processor;
    }
    return failed;
}

// The builder after one of kd-trees would wait for the system, which clears the pages that this one has returned: a
// third of its time. So kd-trees are built first.
static int build_scene(const struct bench_settings *settings, mlrt_pool *pool, const char *word)
{
    struct subject subject;
    struct built built[BUILDER_COUNT] = {{.unsupported = 0}};
    int failed = load_subject(word, NULL, NULL, &subject);
    if (!failed) failed = take_turns(settings, pool, &subject.scene, 0, KDTREE_BUILDER_COUNT, built);
    if (!failed) failed = take_turns(settings, pool, &subject.scene, KDTREE_BUILDER_COUNT, BUILDER_COUNT, built);
    if (!failed) print_builds(settings, &subject, built);
    free_subject(&subject);
    return failed;
}

static int study_build(const struct bench_settings *settings)
{
    mlrt_pool *pool;
    int failed = has_failed(mlrt_create_pool(settings->threads, &pool), "start threads");
    puts("scene,triangles,builder,threads,seconds,processor_seconds,bytes_per_triangle");
    for (size_t i = 0; i < settings->scenes.count && !failed; i++) {
        failed = build_scene(settings, pool, settings->scenes.words[i]);
    }
    mlrt_destroy_pool(pool);
    return failed;
}

int run_study(const struct bench_settings *settings)
{
    if (settings->study == STUDY_TRIANGLES) return study_triangles(settings);
    if (settings->study == STUDY_RESOLUTION) return study_sweep(settings, &settings->scenes, SMALLEST_SIZE);
    if (settings->study == STUDY_CALLS) return study_calls(settings);
    if (settings->study == STUDY_COSTS) return study_costs(settings);
    return study_build(settings);
}
