/* SPDX-License-Identifier: MIT */
/*
 * inspect.c - builds the tree of a scene, or loads a saved one, and prints its report: sizes, depth, triangles left out
 *
 * The tree is one of boxes or a kd-tree (--tree). --save writes it to a file.
 *
 * Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#include "common/cancel.h"
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/tree_file.h"

#include <stdio.h>

static void print_info_of(const mlrt_tree *tree)
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    must_succeed(mlrt_get_tree_info(tree, &info));
    print_tree_info(&info);
}

static int inspect_file(const char *name)
{
    mlrt_tree *tree = NULL;
    struct load_times times;
    int failed = load_tree(name, &tree, &times);
    if (!failed) {
        print_info_of(tree);
        print_count("file_size", times.file_size);
        print_number("tree_load_seconds", times.copied);
        print_number("tree_load_in_place_seconds", times.in_place);
        print_number("memcpy_seconds", times.memcpy_alone);
    }
    mlrt_destroy_tree(tree);
    return failed;
}

// What the library foresees, to compare with memory_size and peak_memory_size.
static void print_estimate(const struct scene *scene, const struct tree_settings *build)
{
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .triangle_count = scene->triangle_count};
    mlrt_memory_estimate estimate = {.struct_size = sizeof estimate};
    if (estimate_by_settings(&mesh, build, &estimate) != MLRT_OK) return;
    print_count("estimated_memory_size", estimate.memory_size);
    print_count("estimated_peak_memory_size", estimate.peak_memory_size);
}

static int inspect(const char *name, const struct tree_settings *build, const char *save_name, uint32_t cancel_count)
{
    struct scene scene;
    mlrt_tree *tree = NULL;
    double start = seconds_now(), build_seconds;
    int failed = load_scene(name, &scene);
    double load_seconds = seconds_now() - start;
    failed = failed || build_tree(&scene, build, &tree, &build_seconds);
    if (!failed) {
        print_count("vertex_count", scene.vertex_count);
        print_info_of(tree);
        print_estimate(&scene, build);
        print_number("load_seconds", load_seconds);
    }
    if (!failed && save_name != NULL) {
        double save_seconds = 0;
        failed = save_tree(tree, save_name, &save_seconds);
        if (!failed) print_number("tree_save_seconds", save_seconds);
    }
    mlrt_destroy_tree(tree);
    if (!failed && cancel_count) failed = study_cancelling(&scene, build, cancel_count);
    free_scene(&scene);
    return failed;
}

int main(int argc, char **argv)
{
    const char *scene = NULL, *save_name = NULL, *load_name = NULL;
    struct tree_settings build = {.kind = TREE_DEFAULT};
    double traversal = 0, intersection = 0;
    uint32_t threads = 1, cancel_count = 0;
    const struct option options[] = {
        {OPTION_TEXT, "--scene", &scene, "NAME|FILE",
         "room, office, building, doubled, scan, scan:N (about N triangles), or a mesh file:\nPLY, OBJ, STL, glTF, ... "
         "(default: office)",
         0, 0},
        TREE_OPTIONS(build),
        {OPTION_COUNT, "--threads", &threads, "N", "threads to build with; 0 = one per processor (default: 1)", 0,
         1024},
        {OPTION_COUNT, "--cancel", &cancel_count, "N",
         "also build N times and stop on the way: how long until it stops,\nand how often it asks", 1, 100000},
        {OPTION_COUNT, "--max-depth", &build.max_depth, "N", "kd-trees: inner nodes above a leaf at most", 1, 60},
        {OPTION_NUMBER, "--traversal-cost", &traversal, "X",
         "of a node step: of boxes in units of a leaf, of kd-trees beside --intersection-cost", 0, 0},
        {OPTION_NUMBER, "--intersection-cost", &intersection, "X", "of a triangle", 0, 0},
        {OPTION_TEXT, "--save", &save_name, "FILE", "write the tree to a file", 0, 0},
        {OPTION_TEXT, "--load", &load_name, "FILE", "report on the tree in a file, and how fast it loads; no scene", 0,
         0},
    };
    int exit_code;
    if (!parse_options("inspect - builds the tree of a scene and prints a report, as lines `name value`", options,
                       sizeof options / sizeof *options, argc, argv, &exit_code))
        return exit_code;
    build.traversal_cost = (float)traversal;
    build.intersection_cost = (float)intersection;
    if (load_name != NULL && (scene != NULL || save_name != NULL || cancel_count)) {
        fprintf(stderr, "--load: reports on that tree alone, without --scene, --save and --cancel\n");
        return 2;
    }
    if (load_name != NULL) return end_output(inspect_file(load_name));
    if (check_tree_settings(&build)) return 2;
    if (threads != 1 && has_failed(mlrt_create_pool(threads, &build.pool), "start threads")) return 1;
    int failed = inspect(scene ? scene : "office", &build, save_name, cancel_count);
    mlrt_destroy_pool(build.pool);
    return end_output(failed);
}
