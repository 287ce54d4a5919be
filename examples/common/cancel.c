/* SPDX-License-Identifier: MIT */
/* cancel.c - how soon a build ends when it is asked to: see cancel.h */
#include "cancel.h"

#include "report.h"
#include "timer.h"
#include "tree.h"

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
    struct longest gap;
};

static struct moment now(void)
{
    struct moment moment = {seconds_now(), thread_seconds_now()};
    return moment;
}

static void note(struct longest *longest, struct moment from, double fraction)
{
    const struct moment to = now();
    if (to.wall - from.wall > longest->seconds.wall) {
        longest->seconds.wall = to.wall - from.wall;
        longest->fraction = fraction;
    }
    if (to.thread - from.thread > longest->seconds.thread) {
        longest->seconds.thread = to.thread - from.thread;
        longest->thread_fraction = fraction;
    }
}

static int32_t on_progress(void *user, double fraction)
{
    struct watch *watch = user;
    note(&watch->gap, watch->last, watch->last_fraction);
    watch->call_count++;
    watch->last_fraction = fraction;
    watch->last = now();
    return fraction >= watch->stop_at;
}

static int32_t build_watched(const struct scene *scene, const mlrt_build_options *build, struct watch *watch)
{
    const mlrt_host host = {.struct_size = sizeof host, .user = watch, .progress = on_progress};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    mlrt_build_options options = *build;
    mlrt_tree *tree = NULL;
    options.host = &host;
    watch->last = now();
    const int32_t status = mlrt_build_kdtree(&mesh, 1, &options, &tree);
    mlrt_destroy_tree(tree);
    return status;
}

static void print_longest(const char *name, const struct longest *longest, int is_alone)
{
    char line[80];
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

int study_cancelling(const struct scene *scene, const mlrt_build_options *build, uint32_t count)
{
    struct watch whole = {.stop_at = 2};
    struct longest wait = {{0, 0}, 0, 0};
    uint32_t cancelled = 0;
    if (build_watched(scene, build, &whole) != MLRT_OK) return 1;
    for (uint32_t i = 0; i < count; i++) {
        struct watch watch = {.stop_at = (double)i / count};
        const int32_t status = build_watched(scene, build, &watch);
        if (status != MLRT_OK && status != MLRT_ERROR_CANCELLED) return 1;
        if (status == MLRT_OK) continue;
        note(&wait, watch.last, watch.last_fraction);
        cancelled++;
    }
    print_count("progress_call_count", whole.call_count);
    print_longest("gap", &whole.gap, build->pool == NULL);
    print_count("cancelled_build_count", cancelled);
    print_longest("wait", &wait, build->pool == NULL);
    return 0;
}
