/* SPDX-License-Identifier: MIT */
/* tree.c - a scene's tree and its report: see tree.h */
#include "tree.h"

#include "report.h"
#include "timer.h"

#include <stdio.h>

int build_tree(const struct scene *scene, const mlrt_build_options *options, mlrt_tree **tree, double *seconds)
{
    char message[256] = "";
    mlrt_build_options with_message = *options;
    with_message.struct_size = sizeof with_message;
    with_message.message = message;
    with_message.message_size = sizeof message;
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = scene->vertices,
                      .vertex_count = scene->vertex_count,
                      .indices = scene->indices,
                      .triangle_count = scene->triangle_count};
    double start = seconds_now();
    int32_t status = mlrt_build_kdtree(&mesh, 1, &with_message, tree);
    *seconds = seconds_now() - start;
    if (status == MLRT_OK) return 0;
    fprintf(stderr, "cannot build the tree: %s%s%s\n", mlrt_status_string(status), *message ? ": " : "", message);
    return 1;
}

void print_tree_info(const mlrt_tree_info *info)
{
    uint64_t in_tree = info->triangle_count - info->non_finite_count - info->zero_area_count;
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
