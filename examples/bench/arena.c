/* SPDX-License-Identifier: MIT */
/* arena.c - a scene, its trees and the contenders: see arena.h */
#include "arena.h"

#include "common/must.h"
#include "common/timer.h"
#include "common/tree.h"

#include <stdio.h>
#include <string.h>

const char *const method_names[6] = {"default", "ray", "packet2", "packet4", "multilevel", "tile"};
const char *const isa_names[6] = {"auto", "scalar", "sse", "avx2", "avx512", "neon"};

static int32_t build_by(const struct library *library, const mlrt_mesh *mesh, int32_t kind, mlrt_pool *pool,
                        mlrt_tree **tree)
{
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes, .preset = kind, .pool = pool};
    const mlrt_kdtree_options kdtree = {.struct_size = sizeof kdtree, .preset = kind - TREE_KDTREE};
    if (library->build_tree) {
        return kind < TREE_KDTREE ? library->build_tree(mesh, 1, &boxes, tree)
                                  : library->build_kdtree(mesh, 1, &kdtree, tree);
    }
    *tree = NULL;
    return kind == TREE_DEFAULT ? library->build_kdtree(mesh, 1, NULL, tree) : MLRT_ERROR_UNSUPPORTED;
}

int32_t build_mlrt(const struct library *library, const struct scene *scene, int32_t kind, mlrt_pool *pool,
                   mlrt_tree **tree, struct span *time)
{
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    const struct span start = span_start();
    const int32_t status = build_by(library, &mesh, kind, pool, tree);
    *time = span_since(start);
    return status;
}

static int build_own_tree(const struct bench_settings *settings, struct arena *arena)
{
    struct span time;
    const int32_t status =
        build_mlrt(&this_library, &arena->subject.scene, settings->tree, arena->pool, &arena->tree, &time);
    arena->build_seconds = time.elapsed;
    if (status == MLRT_OK) return 0;
    fprintf(stderr, "%s: the tree: %s\n", arena->subject.name, mlrt_status_string(status));
    return 1;
}

// The old library's tree, unless it cannot build what was asked for.
static int build_old_tree(const struct bench_settings *settings, struct arena *arena)
{
    struct span time;
    if (!arena->old) return 0;
    const int32_t status =
        build_mlrt(arena->old, &arena->subject.scene, settings->tree, arena->old_pool, &arena->old_tree, &time);
    if (status == MLRT_OK) return 0;
    fprintf(stderr, "%s: the old library's tree: %s\n", arena->subject.name,
            status == MLRT_ERROR_UNSUPPORTED ? "it is from before mlrt_build_tree, and has no other than the default"
                                             : mlrt_status_string(status));
    return status == MLRT_ERROR_OUT_OF_MEMORY;
}

static int build_peers(const struct bench_settings *settings, struct arena *arena)
{
    const struct peer_settings fast = {0, PEER_HIGH_QUALITY, 0, settings->peer_isa},
                               robust = {1, PEER_HIGH_QUALITY, 0, settings->peer_isa};
    if (settings->alone || !have_peer()) return 0;
    arena->fast = create_peer(&arena->subject.scene, &fast, NULL);
    arena->robust = create_peer(&arena->subject.scene, &robust, NULL);
    return !arena->fast || !arena->robust;
}

int open_arena(const struct bench_settings *settings, const char *word, struct arena *arena)
{
    memset(arena, 0, sizeof *arena);
    arena->old = settings->old;
    if (settings->threads > 1) {
        if (has_failed(mlrt_create_pool(settings->threads, &arena->pool), "start threads")) return 1;
        if (arena->old && arena->old->create_pool(settings->threads, &arena->old_pool) != MLRT_OK) {
            fputs("the old library cannot start threads\n", stderr);
            return 1;
        }
        arena->crew = create_crew(settings->threads);
        if (!arena->crew) return 1;
    }
    return load_subject(word, settings->views, settings->view, &arena->subject) || build_own_tree(settings, arena) ||
           build_old_tree(settings, arena) || build_peers(settings, arena);
}

void close_arena(struct arena *arena)
{
    mlrt_destroy_tree(arena->tree);
    destroy_peer(arena->fast);
    destroy_peer(arena->robust);
    mlrt_destroy_pool(arena->pool);
    if (arena->old) arena->old->destroy_tree(arena->old_tree), arena->old->destroy_pool(arena->old_pool);
    destroy_crew(arena->crew);
    free_subject(&arena->subject);
}

// With one thread, and with all if they are more.
static void add_contender(const struct bench_settings *settings, enum who who, int32_t method, int32_t isa,
                          struct contest *contest)
{
    for (int all = 0; all <= (settings->threads > 1) && contest->count < MAXIMUM_CONTENDERS; all++) {
        contest->contenders[contest->count++] =
            (struct contender){.who = who,
                               .method = method,
                               .isa = isa,
                               .threads = all ? settings->threads : 1,
                               .unsupported = who == OLD_LIBRARY && !contest->old_tree};
    }
}

int start_contest(const struct bench_settings *settings, const struct arena *arena, enum kind kind, struct task *task,
                  struct contest *contest)
{
    *contest = (struct contest){.task = task,
                                .tree = arena->tree,
                                .old = arena->old,
                                .old_tree = arena->old_tree,
                                .old_pool = arena->old_pool,
                                .fast = arena->fast,
                                .robust = arena->robust,
                                .pool = arena->pool,
                                .crew = arena->crew,
                                .runs = settings->runs,
                                .paced = settings->paced};
    for (int32_t i = 0; i < 6 * 5; i++) {
        const int32_t method = i / 5, isa = i % 5;
        if (!(settings->methods & 1u << method) || !(settings->isas & 1u << isa)) continue;
        add_contender(settings, LIBRARY, method, isa, contest);
        if (contest->old) add_contender(settings, OLD_LIBRARY, method, isa, contest);
    }
    if (arena->robust) {
        add_contender(settings, PEER_FAST, 0, 0, contest);
        add_contender(settings, PEER_ROBUST, 0, 0, contest);
    }
    if (settings->threads > 1) add_contender(settings, SPIN_LOOP, 0, 0, contest);
    return make_task(kind, &arena->subject, arena->tree, arena->pool, task);
}

static double mrays_of(const struct contender *contender)
{
    return contender ? contender->mrays : 0;
}

void print_csv_line(const struct contest *contest, const struct contender *contender)
{
    printf("%s,%s,%s,%s,%u,%.3f,%.3f,%.3f", contest->task->subject->name, kind_names[contest->task->kind],
           method_names[contender->method], isa_names[contender->isa], (unsigned)contender->threads, contender->mrays,
           mrays_of(find_contender(contest, PEER_FAST, contender->threads)),
           mrays_of(find_contender(contest, PEER_ROBUST, contender->threads)));
}

void end_csv_line(const struct contest *contest, const struct contender *contender)
{
    if (contest->old) printf(",%.3f", mrays_of(find_old(contest, contender)));
    putchar('\n');
}

void end_csv_head(const struct bench_settings *settings)
{
    puts(settings->old ? ",old_mrays" : "");
}
