/* SPDX-License-Identifier: MIT */
/*
 * inspect.c - builds the tree of a scene and prints the build report: sizes, depth, what was left out and why
 *
 * Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/timer.h"
#include "common/tree.h"

#include <stdio.h>

static int inspect(const char *name, const mlrt_build_options *build)
{
    struct scene scene;
    mlrt_tree *tree = NULL;
    double start = seconds_now(), build_seconds;
    int failed = load_scene(name, &scene);
    double load_seconds = seconds_now() - start;
    failed = failed || build_tree(&scene, build, &tree, &build_seconds);
    if (!failed) {
        mlrt_tree_info info = {.struct_size = sizeof info};
        mlrt_get_tree_info(tree, &info);
        print_count("vertex_count", scene.vertex_count);
        print_tree_info(&info);
        print_number("load_seconds", load_seconds);
    }
    mlrt_destroy_tree(tree);
    free_scene(&scene);
    return failed;
}

int main(int argc, char **argv)
{
    const char *scene = "office";
    mlrt_build_options build = {.struct_size = sizeof build};
    double traversal = 0, intersection = 0;
    uint32_t threads = 1;
    const struct option options[] = {
        {OPTION_TEXT, "--scene", &scene, "NAME|FILE",
         "room, office, building, scan, scan:N (about N triangles), or a mesh file:\nPLY, OBJ, STL, glTF, ... "
         "(default: office)",
         0, 0},
        TREE_OPTIONS(build),
        {OPTION_COUNT, "--threads", &threads, "N", "threads to build with; 0 = one per processor (default: 1)", 0,
         1024},
        {OPTION_COUNT, "--max-depth", &build.max_depth, "N", "inner nodes above a leaf at most", 1, 60},
        {OPTION_NUMBER, "--traversal-cost", &traversal, "X",
         "of a node step; only its ratio to --intersection-cost matters", 0, 0},
        {OPTION_NUMBER, "--intersection-cost", &intersection, "X", "of a triangle test", 0, 0},
    };
    int exit_code;
    if (!parse_options("inspect - builds the tree of a scene and prints a report, as lines `name value`", options,
                       sizeof options / sizeof *options, argc, argv, &exit_code))
        return exit_code;
    build.traversal_cost = (float)traversal;
    build.intersection_cost = (float)intersection;
    if (mlrt_create_pool(threads, &build.pool) != MLRT_OK) {
        fprintf(stderr, "cannot start %u threads\n", (unsigned)threads);
        return 1;
    }
    int failed = inspect(scene, &build);
    mlrt_destroy_pool(build.pool);
    return failed;
}
