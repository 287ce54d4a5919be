/* SPDX-License-Identifier: MIT */
/* arena.h - the settings of the command line, and one scene with all that its contests need */
#ifndef ARENA_H
#define ARENA_H

#include "common/options.h"
#include "common/timer.h"
#include "contest.h"

enum { STUDY_NONE, STUDY_TRIANGLES, STUDY_RESOLUTION, STUDY_BUILD, STUDY_CALLS, STUDY_COSTS };

struct bench_settings {
    struct word_list scenes, default_scenes;
    struct word_list trees; /* shared objects, builds of the library, whose trees the study of costs compares as well */
    const char *views, *view, *against;
    uint32_t size, threads, runs;
    uint32_t kinds, methods, isas; /* a bit for each */
    int32_t tree;                  /* common/tree.h: TREE_* */
    int32_t study;
    int32_t peer_isa; /* PEER_ISA_* */
    int csv;
    int alone;                 /* without Embree */
    int paced;                 /* contest.h */
    const struct library *old; /* what `against` names, or NULL */
};

extern const char *const method_names[6], *const isa_names[6];

struct arena {
    struct subject subject;
    mlrt_tree *tree;
    double build_seconds;
    mlrt_pool *pool;
    struct crew *crew;
    const struct library *old; /* NULL = there is none */
    mlrt_tree *old_tree;       /* NULL = it cannot build what was asked for */
    mlrt_pool *old_pool;
    struct peer *fast, *robust;
};

/* Loads and builds. Returns 0, or 1 after a message on stderr. Close it either way. */
int open_arena(const struct bench_settings *settings, const char *word, struct arena *arena);
void close_arena(struct arena *arena);

/* Builds a tree of a kind (TREE_*); MLRT_ERROR_UNSUPPORTED where the library is too old for it. */
int32_t build_mlrt(const struct library *library, const struct scene *scene, int32_t kind, mlrt_pool *pool,
                   mlrt_tree **tree, struct span *time);

/* Prepares a task of the arena's scene, and its contenders. Returns 0 or 1; free the task either way. */
int start_contest(const struct bench_settings *settings, const struct arena *arena, enum kind kind, struct task *task,
                  struct contest *contest);

/* scene,kind,method,isa,threads,mrays,embree_fast_mrays,embree_robust_mrays, without an end of line */
void print_csv_line(const struct contest *contest, const struct contender *contender);

/* Ends a line: with the old library ,old_mrays goes before (0 = it cannot do this). Likewise the head of the table. */
void end_csv_line(const struct contest *contest, const struct contender *contender);
void end_csv_head(const struct bench_settings *settings);

#endif
