/* SPDX-License-Identifier: MIT */
/* tree.c - a scene's tree and its report: see tree.h */
#include "tree.h"

#include "report.h"
#include "timer.h"

#include <stdio.h>

int is_kdtree(const struct tree_settings *settings)
{
    return settings->kind >= TREE_KDTREE;
}

int check_tree_settings(const struct tree_settings *settings)
{
    const char *wrong = NULL;
    if (is_kdtree(settings)) return 0;
    if (settings->max_depth) wrong = "--max-depth";
    if (settings->rules_off) wrong = "--rules-off";
    if (wrong) fprintf(stderr, "%s: of kd-trees only; --tree kdtree or --tree kdtree-tuned builds one\n", wrong);
    return wrong != NULL;
}

static mlrt_tree_options tree_options(const struct tree_settings *settings)
{
    return (mlrt_tree_options){.struct_size = sizeof(mlrt_tree_options),
                               .preset = settings->kind - TREE_DEFAULT + MLRT_TREE_DEFAULT,
                               .traversal_cost = settings->traversal_cost,
                               .intersection_cost = settings->intersection_cost,
                               .pool = settings->pool,
                               .host = settings->host};
}

static mlrt_kdtree_options kdtree_options(const struct tree_settings *settings)
{
    return (mlrt_kdtree_options){.struct_size = sizeof(mlrt_kdtree_options),
                                 .preset = settings->kind - TREE_KDTREE + MLRT_KDTREE_PAPER,
                                 .traversal_cost = settings->traversal_cost,
                                 .intersection_cost = settings->intersection_cost,
                                 .max_depth = settings->max_depth,
                                 .rules_off = settings->rules_off,
                                 .pool = settings->pool,
                                 .host = settings->host};
}

int32_t build_by_settings(const mlrt_mesh *mesh, const struct tree_settings *settings, char *message,
                          size_t message_size, mlrt_tree **tree)
{
    if (is_kdtree(settings)) {
        mlrt_kdtree_options options = kdtree_options(settings);
        options.message = message;
        options.message_size = message_size;
        return mlrt_build_kdtree(mesh, 1, &options, tree);
    }
    mlrt_tree_options options = tree_options(settings);
    options.message = message;
    options.message_size = message_size;
    return mlrt_build_tree(mesh, 1, &options, tree);
}

int32_t estimate_by_settings(const mlrt_mesh *mesh, const struct tree_settings *settings,
                             mlrt_memory_estimate *estimate)
{
    const mlrt_tree_options boxes = tree_options(settings);
    const mlrt_kdtree_options kdtree = kdtree_options(settings);
    return is_kdtree(settings) ? mlrt_estimate_kdtree(mesh, 1, &kdtree, estimate)
                               : mlrt_estimate_tree(mesh, 1, &boxes, estimate);
}

int build_tree(const struct scene *scene, const struct tree_settings *settings, mlrt_tree **tree, double *seconds)
{
    char message[256] = "";
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    double start = seconds_now();
    int32_t status = build_by_settings(&mesh, settings, message, sizeof message, tree);
    *seconds = seconds_now() - start;
    if (status == MLRT_OK) return 0;
    fprintf(stderr, "cannot build the tree: %s%s%s\n", mlrt_status_string(status), *message ? ": " : "", message);
    return 1;
}

void print_tree_info(const mlrt_tree_info *info)
{
    uint64_t in_tree = info->triangle_count - info->non_finite_count - info->zero_area_count;
    print_count("is_kdtree", info->structure == MLRT_STRUCTURE_KDTREE);
    print_count("triangle_count", info->triangle_count);
    print_count("left_out_non_finite_count", info->non_finite_count);
    print_count("left_out_zero_area_count", info->zero_area_count);
    print_count("depth", info->depth);
    print_count("node_count", info->node_count);
    print_count("leaf_count", info->leaf_count);
    print_count("empty_leaf_count", info->empty_leaf_count);
    print_count("reference_count", info->reference_count);
    print_count("retracted_count", info->retracted_count);
    print_ratio("references_per_triangle", (double)info->reference_count, (double)in_tree);
    print_ratio("references_per_full_leaf", (double)info->reference_count,
                (double)(info->leaf_count - info->empty_leaf_count));
    print_number("sah_cost", info->sah_cost);
    print_count("memory_size", info->memory_size);
    print_count("peak_memory_size", info->peak_memory_size);
    print_ratio("bytes_per_triangle", (double)info->memory_size, (double)info->triangle_count);
    print_ratio("peak_bytes_per_triangle", (double)info->peak_memory_size, (double)info->triangle_count);
    print_hash("tree_hash", info->tree_hash);
    print_vector("bounds_min", info->bounds_min);
    print_vector("bounds_max", info->bounds_max);
    print_number("build_seconds", info->build_seconds);
}
