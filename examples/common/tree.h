/* SPDX-License-Identifier: MIT */
/* tree.h - a scene's tree, boxes or kd-tree, by the options of a program, and its report */
#ifndef TREE_H
#define TREE_H

#include "options.h"
#include "scene.h"

#include <mlrt.h>

/* What to build, in the order of the words of --tree: boxes by mlrt_build_tree, or a kd-tree by mlrt_build_kdtree. */
enum { TREE_DEFAULT, TREE_FAST, TREE_BEST, TREE_KDTREE, TREE_KDTREE_TUNED };
#define TREE_WORDS "default|fast|best|kdtree|kdtree-tuned"

/* How to build it. All 0 = the default. What only one of the builders has must be 0 for the other. */
struct tree_settings {
    int32_t kind; /* TREE_* */
    float traversal_cost, intersection_cost;
    uint32_t max_depth, rules_off; /* kd-trees */
    mlrt_pool *pool;               /* whose threads build; NULL = the calling thread */
    const mlrt_host *host;
};

/* Rows of an options table. */
#define TREE_OPTIONS(settings)                                                                                         \
    {OPTION_CHOICE,                                                                                                    \
     "--tree",                                                                                                         \
     &(settings).kind,                                                                                                 \
     TREE_WORDS,                                                                                                       \
     "boxes: traced fastest, built fastest, or slower to build than\nthe default; or kd-trees: the paper's, or one "   \
     "tuned for this library",                                                                                         \
     TREE_DEFAULT,                                                                                                     \
     0},                                                                                                               \
    {                                                                                                                  \
        OPTION_SET, "--rules-off", &(settings).rules_off, "empty,coplanar,minimum,clip,retract",                       \
            "kd-trees: builder rules to leave out, a list: empty space cut off first,\nplanes covered by triangles, "  \
            "no cells under a minimum size,\ncandidates clipped to the cell, subtrees that do not pay turned back "    \
            "into leaves",                                                                                             \
            0, 0                                                                                                       \
    }

int is_kdtree(const struct tree_settings *settings);

/* Returns 0, or 1 after saying on stderr which option the tree that is asked for does not have. */
int check_tree_settings(const struct tree_settings *settings);

/* The library's calls, by the builder that the settings ask for. They return its status; `message` may be NULL. */
int32_t build_by_settings(const mlrt_mesh *mesh, const struct tree_settings *settings, char *message,
                          size_t message_size, mlrt_tree **tree);
int32_t estimate_by_settings(const mlrt_mesh *mesh, const struct tree_settings *settings,
                             mlrt_memory_estimate *estimate);

/* Builds the tree of a scene; *seconds receives the time that it took. Returns 0, or 1 after a message on stderr. */
int build_tree(const struct scene *scene, const struct tree_settings *settings, mlrt_tree **tree, double *seconds);

/* Prints the build report as `name value` lines. */
void print_tree_info(const mlrt_tree_info *info);

#endif
