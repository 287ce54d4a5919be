/* SPDX-License-Identifier: MIT */
/*
 * Trees as the caller sees them: building one, what it will need and what it took, and its end.
 */
#include <string.h>

#include "api/save.h"
#include "base/host.h"
#include "base/platform.h"
#include "base/progress.h"
#include "base/structs.h"
#include "bvh/build.h"
#include "mlrta/build.h"
#include "mlrta/kdtree.h"
#include "scene/meshes.h"

/* ---- options ---- */

/* A call that builds: its options and host, checked, in whatever version they came. */
struct call {
    mlrt_build_options options;
    struct mlrt_voice voice;
};

static MLRT_NOINLINE int32_t check_options(const mlrt_build_options *options)
{
    if (options->preset < MLRT_TREE_DEFAULT || options->preset > MLRT_TREE_BEST) return MLRT_ERROR_ARGUMENT;
    if (options->structures & ~3u || options->reserved != 0) return MLRT_ERROR_ARGUMENT;
    if (options->rules_off & ~31u || options->max_depth > MLRT_DEPTH_LIMIT) return MLRT_ERROR_ARGUMENT;
    if (!(options->traversal_cost >= 0 && options->traversal_cost <= 1e6f)) return MLRT_ERROR_ARGUMENT;
    if (!(options->intersection_cost >= 0 && options->intersection_cost <= 1e6f)) return MLRT_ERROR_ARGUMENT;
    return MLRT_OK;
}

/* The paper's kind of tree is a kd-tree. */
static uint32_t resolve_structures(const mlrt_build_options *options)
{
    if (options->preset == MLRT_TREE_PAPER) return options->structures | MLRT_STRUCTURE_KDTREE;
    return options->structures ? options->structures : MLRT_STRUCTURE_BVH;
}

static int32_t take_options(const mlrt_build_options *given, struct call *call)
{
    memset(call, 0, sizeof *call);
    if (given) {
        const int32_t status = mlrt_take_struct(given, MLRT_SIZE_UP_TO(mlrt_build_options, reserved), &call->options,
                                                sizeof call->options);
        if (status != MLRT_OK) return status;
    }
    call->voice.message = call->options.message;
    call->voice.message_size = call->options.message_size;
    mlrt_begin_message(&call->voice);
    call->options.structures = resolve_structures(&call->options);
    const uint64_t environment = mlrt_enter_fp_environment();
    const int32_t status = check_options(&call->options);
    mlrt_leave_fp_environment(environment);
    return status == MLRT_OK ? mlrt_take_host(call->options.host, &call->voice.host) : status;
}

/* ---- building ---- */

static double work_per_triangle(const mlrt_build_options *options)
{
    return MLRT_COPY_WORK + (options->structures & MLRT_STRUCTURE_KDTREE ? MLRT_KDTREE_WORK : 0) +
           (options->structures & MLRT_STRUCTURE_BVH ? MLRT_BVH_WORK : 0);
}

static int32_t fill_tree(const mlrt_mesh *meshes, size_t mesh_count, const struct call *call, struct mlrt_tree *tree)
{
    const mlrt_build_options *options = &call->options;
    struct mlrt_progress progress;
    int32_t status = mlrt_check_meshes(meshes, mesh_count, &tree->triangle_count);
    if (status != MLRT_OK) return status;
    mlrt_begin_progress(&call->voice.host, work_per_triangle(options) * tree->triangle_count, &progress);
    status = mlrt_copy_meshes(meshes, mesh_count, &call->voice, &progress, tree);
    tree->structures = options->structures;
    if (status == MLRT_OK && tree->structures & MLRT_STRUCTURE_KDTREE) {
        status = mlrt_build_nodes(tree, options, &progress);
    }
    if (status == MLRT_OK && tree->structures & MLRT_STRUCTURE_BVH) {
        status = mlrt_build_bvh(tree, options, &progress);
    }
    return mlrt_end_progress(&progress, status);
}

struct mlrt_tree *mlrt_allocate_tree(const struct mlrt_memory *memory)
{
    struct mlrt_memory own = *memory;
    struct mlrt_tree *tree = mlrt_allocate_zeroed(&own, 1, sizeof *tree);
    if (tree) tree->memory = own;
    return tree;
}

static void tell_result(const struct mlrt_voice *voice, const mlrt_tree_info *info)
{
    const uint64_t left_out = info->non_finite_count + info->zero_area_count;
    if (!voice->host.log) return;
    if (left_out) {
        mlrt_log(voice, MLRT_LOG_WARNING, "%.0f triangles can never be hit: %.0f are not finite, %.0f have no area",
                 (double)left_out, (double)info->non_finite_count, (double)info->zero_area_count);
    }
    mlrt_log(voice, MLRT_LOG_INFO, "tree of %.0f triangles: %.0f bytes, %.0f at most, in %.3f s",
             (double)info->triangle_count, (double)info->memory_size, (double)info->peak_memory_size,
             info->build_seconds);
}

static void tell_failure(const struct call *call, const struct mlrt_memory *memory, int32_t status)
{
    const uint64_t limit = call->options.memory_limit;
    if (status == MLRT_ERROR_OUT_OF_MEMORY && limit) {
        mlrt_explain(&call->voice, "out of memory: %.0f bytes held, limit %.0f", (double)memory->held_size,
                     (double)limit);
    } else if (status == MLRT_ERROR_CANCELLED) {
        mlrt_log(&call->voice, MLRT_LOG_INFO, "stopped by the host");
    } else if (status != MLRT_ERROR_INDEX_RANGE) {
        mlrt_explain(&call->voice, "%s", mlrt_status_string(status));
    }
}

static MLRT_NOINLINE int32_t build_tree(const mlrt_mesh *meshes, size_t mesh_count, const struct call *call,
                                        mlrt_tree **tree)
{
    const double start = mlrt_seconds_now();
    const struct mlrt_memory memory = mlrt_host_memory(&call->voice.host, call->options.memory_limit);
    struct mlrt_tree *made = mlrt_allocate_tree(&memory);
    const int32_t status = made ? fill_tree(meshes, mesh_count, call, made) : MLRT_ERROR_OUT_OF_MEMORY;
    if (status != MLRT_OK) {
        tell_failure(call, made ? &made->memory : &memory, status);
        mlrt_destroy_tree(made);
        return status;
    }
    made->info.struct_size = sizeof made->info;
    made->info.triangle_count = made->triangle_count;
    made->info.memory_size = made->memory.held_size;
    made->info.peak_memory_size = made->memory.peak_size;
    made->info.build_seconds = mlrt_seconds_now() - start;
    made->memory.limit_size = 0;
    tell_result(&call->voice, &made->info);
    *tree = made;
    return MLRT_OK;
}

MLRT_API int32_t mlrt_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_build_options *options,
                                   mlrt_tree **tree)
{
    if (!tree) return MLRT_ERROR_ARGUMENT;
    *tree = NULL;
    struct call call;
    int32_t status = take_options(options, &call);
    if (status != MLRT_OK) return status;
    const uint64_t environment = mlrt_enter_fp_environment();
    status = build_tree(meshes, mesh_count, &call, tree);
    mlrt_leave_fp_environment(environment);
    return status;
}

/* ---- the finished tree ---- */

MLRT_API void mlrt_destroy_tree(mlrt_tree *tree)
{
    if (!tree) return;
    mlrt_return_arrays(tree);
    mlrt_free_meshes(tree);
    mlrt_free_bvh(tree);
    mlrt_free(&tree->memory, tree->nodes, tree->node_count, sizeof *tree->nodes);
    mlrt_free(&tree->memory, tree->references, tree->reference_count, sizeof *tree->references);
    struct mlrt_memory memory = tree->memory;
    mlrt_free(&memory, tree, 1, sizeof *tree);
}

MLRT_API int32_t mlrt_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info)
{
    if (!tree || !info) return MLRT_ERROR_ARGUMENT;
    const int32_t status = mlrt_check_result_size(info, MLRT_SIZE_UP_TO(mlrt_tree_info, bounds_max), sizeof *info);
    if (status == MLRT_OK) mlrt_give_struct(&tree->info, sizeof tree->info, info);
    return status;
}

/* ---- memory, before ---- */

static MLRT_NOINLINE void foresee(const mlrt_build_options *options, uint32_t triangle_count, int have_masks,
                                  size_t mesh_count, mlrt_memory_estimate *estimate)
{
    const uint64_t size = sizeof(struct mlrt_triangle) + (have_masks ? sizeof(uint32_t) : 0);
    const uint64_t always = sizeof(struct mlrt_tree) + triangle_count * size + mesh_count * 3 * sizeof(uint32_t);
    struct mlrt_demand kdtree = {0, 0}, boxes = {0, 0};
    if (options->structures & MLRT_STRUCTURE_KDTREE) kdtree = mlrt_foresee_nodes(options, triangle_count);
    if (options->structures & MLRT_STRUCTURE_BVH) boxes = mlrt_foresee_bvh(options, triangle_count);
    const uint64_t with_boxes = kdtree.held_size + boxes.peak_size;
    estimate->memory_size = always + kdtree.held_size + boxes.held_size;
    estimate->peak_memory_size = always + (kdtree.peak_size > with_boxes ? kdtree.peak_size : with_boxes);
}

MLRT_API int32_t mlrt_estimate_memory(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_build_options *options,
                                      mlrt_memory_estimate *estimate)
{
    if (!estimate) return MLRT_ERROR_ARGUMENT;
    mlrt_memory_estimate own;
    struct call call;
    uint32_t triangle_count;
    int32_t status =
        mlrt_check_result_size(estimate, MLRT_SIZE_UP_TO(mlrt_memory_estimate, peak_memory_size), sizeof own);
    if (status == MLRT_OK) status = take_options(options, &call);
    if (status == MLRT_OK) status = mlrt_check_meshes(meshes, mesh_count, &triangle_count);
    if (status != MLRT_OK) return status;
    memset(&own, 0, sizeof own);
    const uint64_t environment = mlrt_enter_fp_environment();
    foresee(&call.options, triangle_count, mlrt_have_masks(meshes, mesh_count), mesh_count, &own);
    mlrt_leave_fp_environment(environment);
    mlrt_give_struct(&own, sizeof own, estimate);
    return MLRT_OK;
}
