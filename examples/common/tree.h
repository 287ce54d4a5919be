/* SPDX-License-Identifier: MIT */
/* tree.h - a scene's tree, with the options that programs have for it, and its report */
#ifndef TREE_H
#define TREE_H

#include "options.h"
#include "scene.h"

#include <mlrt.h>

/* A row of an options table for each field of mlrt_build_options that a command line sets. */
#define TREE_OPTIONS(build)                                                                                            \
    {OPTION_CHOICE,                                                                                                    \
     "--tree",                                                                                                         \
     &(build).preset,                                                                                                  \
     "default|paper|fast|best",                                                                                        \
     "the fastest kind of tree, the paper's: deep, small leaves,\nbuilt fastest, or slower to build than the default", \
     MLRT_TREE_DEFAULT,                                                                                                \
     0},                                                                                                               \
        {OPTION_SET, "--structure", &(build).structures, "kdtree,bvh", "what to search in, a list (default: bvh)", 0,  \
         0},                                                                                                           \
    {                                                                                                                  \
        OPTION_SET, "--rules-off", &(build).rules_off, "empty,coplanar,minimum,clip,retract",                          \
            "builder rules to leave out, a list: empty space cut off first, planes covered\nby triangles, no cells "   \
            "under a "                                                                                                 \
            "minimum size, candidates clipped to the cell,\nsubtrees that do not pay turned back into leaves",         \
            0, 0                                                                                                       \
    }

/* Builds the tree of a scene. Returns 0, or 1 after saying on stderr what is wrong. *seconds receives how long it took.
 */
int build_tree(const struct scene *scene, const mlrt_build_options *options, mlrt_tree **tree, double *seconds);

/* Prints the build report as `name value` lines. */
void print_tree_info(const mlrt_tree_info *info);

#endif
