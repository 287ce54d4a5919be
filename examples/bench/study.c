/* SPDX-License-Identifier: MIT */
/* study.c - sweeps and builds: see study.h */
#include "study.h"

#include <stdio.h>

enum { SMALLEST_SIZE = 256 };

uint32_t default_kinds(int32_t study)
{
    if (study == STUDY_TRIANGLES) return 1u << PRIMARY | 1u << BOUNCE;
    if (study == STUDY_RESOLUTION) return 1u << FRAME;
    return (1u << KIND_COUNT) - 1;
}

/* ---- sweeps -------------------------------------------------------------------------------------------------------
 */

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
        printf(",%zu,%lu\n", arena->subject.scene.triangle_count, (unsigned long)size);
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
    for (uint32_t size = smallest; size <= largest && arena.tree && !failed; size *= 2) {
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
    puts("scene,kind,method,isa,threads,mrays,embree_fast_mrays,embree_robust_mrays,triangles,size");
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

/* ---- building -----------------------------------------------------------------------------------------------------
 */

static int study_build(const struct bench_settings *settings)
{
    (void)settings;
    fprintf(stderr, "not yet\n");
    return 1;
}

int run_study(const struct bench_settings *settings)
{
    if (settings->study == STUDY_TRIANGLES) return study_triangles(settings);
    if (settings->study == STUDY_RESOLUTION) return study_sweep(settings, &settings->scenes, SMALLEST_SIZE);
    return study_build(settings);
}
