/* SPDX-License-Identifier: MIT */
/* cancel.c - measures how soon a cancelled build ends: see cancel.h */
#define _POSIX_C_SOURCE 200112L
#include "cancel.h"

#include "must.h"
#include "report.h"
#include "timer.h"

#include <stdio.h>
#include <stdlib.h>

// Two clocks: everybody's, and that of the calling thread.
struct moment {
    double wall, thread;
};

struct longest {
    struct moment seconds; // each by itself
    double fraction;       // of the build, when the longest by the wall clock began
    double thread_fraction;
};

struct watch {
    double stop_at; // above 1 = never
    struct moment last;
    double last_fraction;
    uint32_t call_count;
    struct moment freeing; // since then, in the system's free
    struct longest gap, gap_besides;
};

static struct moment now(void)
{
    struct moment moment = {seconds_now(), thread_seconds_now()};
    return moment;
}

// The time from one moment to another, less what was spent in between on something else.
static void note(struct longest *longest, struct moment from, struct moment to, double fraction)
{
    if (to.wall - from.wall > longest->seconds.wall) {
        longest->seconds.wall = to.wall - from.wall;
        longest->fraction = fraction;
    }
    if (to.thread - from.thread > longest->seconds.thread) {
        longest->seconds.thread = to.thread - from.thread;
        longest->thread_fraction = fraction;
    }
}

static struct moment less(struct moment moment, struct moment spent)
{
    return (struct moment){moment.wall - spent.wall, moment.thread - spent.thread};
}

static void *allocate(void *user, size_t size, size_t alignment)
{
    void *block = NULL;
    (void)user;
    return posix_memalign(&block, alignment, size) == 0 ? block : NULL;
}

static void free_timed(void *user, void *block, size_t size, size_t alignment)
{
    struct watch *watch = user;
    const struct moment start = now();
    (void)size;
    (void)alignment;
    free(block);
    const struct moment spent = less(now(), start);
    watch->freeing.wall += spent.wall;
    watch->freeing.thread += spent.thread;
}

static int32_t on_progress(void *user, double fraction)
{
    static const struct moment none;
    struct watch *watch = user;
    const struct moment then = now();
    note(&watch->gap, watch->last, then, watch->last_fraction);
    note(&watch->gap_besides, watch->last, less(then, watch->freeing), watch->last_fraction);
    watch->freeing = none;
    watch->call_count++;
    watch->last_fraction = fraction;
    watch->last = now();
    return fraction >= watch->stop_at;
}

static int32_t build_watched(const struct scene *scene, const struct tree_settings *build, struct watch *watch)
{
    const mlrt_host host = {
        .struct_size = sizeof host, .user = watch, .allocate = allocate, .free = free_timed, .progress = on_progress};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    struct tree_settings settings = *build;
    mlrt_tree *tree = NULL;
    settings.host = &host;
    watch->last = now();
    const int32_t status = build_by_settings(&mesh, &settings, NULL, 0, &tree);
    mlrt_destroy_tree(tree);
    return status;
}

static void print_longest(const char *name, const struct longest *longest, int is_alone)
{
    char line[96];
    snprintf(line, sizeof line, "longest_%s_milliseconds", name);
    print_number(line, 1e3 * longest->seconds.wall);
    snprintf(line, sizeof line, "longest_%s_fraction", name);
    print_number(line, longest->fraction);
    if (!is_alone) return;
    snprintf(line, sizeof line, "longest_%s_thread_milliseconds", name);
    print_number(line, 1e3 * longest->seconds.thread);
    snprintf(line, sizeof line, "longest_%s_thread_fraction", name);
    print_number(line, longest->thread_fraction);
}

int study_cancelling(const struct scene *scene, const struct tree_settings *build, uint32_t count)
{
    struct watch whole = {.stop_at = 2};
    struct longest wait = {{0, 0}, 0, 0}, wait_besides = wait;
    uint32_t cancelled = 0;
    if (has_failed(build_watched(scene, build, &whole), "build the tree again")) return 1;
    for (uint32_t i = 0; i < count; i++) {
        struct watch watch = {.stop_at = (double)i / count};
        const int32_t status = build_watched(scene, build, &watch);
        if (status != MLRT_ERROR_CANCELLED && has_failed(status, "build the tree again")) return 1;
        if (status == MLRT_OK) continue;
        const struct moment end = now();
        note(&wait, watch.last, end, watch.last_fraction);
        note(&wait_besides, watch.last, less(end, watch.freeing), watch.last_fraction);
        cancelled++;
    }
    print_count("progress_call_count", whole.call_count);
    print_longest("gap", &whole.gap, build->pool == NULL);
    print_longest("gap_besides_freeing", &whole.gap_besides, build->pool == NULL);
    print_count("cancelled_build_count", cancelled);
    print_longest("wait", &wait, build->pool == NULL);
    print_longest("wait_besides_freeing", &wait_besides, build->pool == NULL);
    return 0;
}
