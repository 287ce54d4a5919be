/* SPDX-License-Identifier: MIT */
/* The exported functions for trees: build, report, estimate memory, destroy. */
#include <string.h>

#include "base/host.h"
#include "base/platform.h"
#include "base/progress.h"
#include "base/structs.h"
#include "job/structure.h"
#include "scene/meshes.h"

/* ---- options ---- */

/*
 * The checked arguments of a call that builds. Options of other versions are converted to this one. The options of both
 * builders begin with the same fields, up to memory_limit.
 */
struct call {
    const struct mlrt_structure *structure;
    union {
        mlrt_tree_options tree;
        mlrt_kdtree_options kdtree;
    } options;
    struct mlrt_voice voice;
};

/* take_options and build_tree read the common fields of both kinds of options through the union's `tree`. */
#define SAME_PLACE(field) (offsetof(mlrt_tree_options, field) == offsetof(mlrt_kdtree_options, field))
typedef char options_begin_alike[SAME_PLACE(preset) && SAME_PLACE(traversal_cost) && SAME_PLACE(intersection_cost) &&
                                         SAME_PLACE(message) && SAME_PLACE(message_size) && SAME_PLACE(host) &&
                                         SAME_PLACE(memory_limit)
                                     ? 1
                                     : -1];

static int32_t take_options(const void *given, const struct mlrt_structure *structure, struct call *call)
{
    const int form = structure->builder.options_form;
    const mlrt_tree_options *options = &call->options.tree;
    memset(call, 0, sizeof *call);
    call->structure = structure;
    const int32_t status = mlrt_copy_struct(form, "options", 0, given, &call->options);
    return status != MLRT_OK
               ? status
               : mlrt_begin_call(form, options, options->message, options->message_size, options->host, &call->voice);
}

/* ---- building ---- */

static int32_t fill_tree(const mlrt_mesh *meshes, size_t mesh_count, const struct call *call, struct mlrt_tree *tree)
{
    const int is_kdtree = call->structure->builder.options_form == MLRT_STRUCT_KDTREE_OPTIONS;
    mlrt_pool *pool = is_kdtree ? call->options.kdtree.pool : call->options.tree.pool;
    struct mlrt_progress progress;
    int32_t status = mlrt_check_meshes(meshes, mesh_count, &tree->triangle_count);
    if (status != MLRT_OK) return status;
    const double work = MLRT_COPY_WORK + (double)tree->structure->builder.work;
    mlrt_begin_progress(&call->voice.host, work * tree->triangle_count, &progress);
    status = mlrt_copy_meshes(meshes, mesh_count, pool, &progress, tree);
    if (status == MLRT_OK) status = tree->structure->builder.build(tree, &call->options, &progress);
    return mlrt_end_progress(&progress, status);
}

static void log_result(const struct mlrt_voice *voice, const mlrt_tree_info *info)
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

/* Writes the message of an error that has none yet. */
static void note_failure(const struct call *call, const struct mlrt_memory *memory, int32_t status)
{
    const double limit = (double)call->options.tree.memory_limit, held = (double)memory->held_size;
    if (status == MLRT_ERROR_CANCELLED) {
        (void)mlrt_fail(status, "stopped by the host");
    } else if (status == MLRT_ERROR_OUT_OF_MEMORY && limit > 0) {
        (void)mlrt_fail(status, "out of memory: %.0f bytes held, limit %.0f", held, limit);
    } else if (status == MLRT_ERROR_OUT_OF_MEMORY) {
        (void)mlrt_note_status(status);
    }
}

static MLRT_NOINLINE int32_t build_tree(const mlrt_mesh *meshes, size_t mesh_count, const struct call *call,
                                        mlrt_tree **tree)
{
    const double start = mlrt_seconds_now();
    const struct mlrt_memory memory = mlrt_host_memory(&call->voice.host, call->options.tree.memory_limit);
    struct mlrt_tree *made = mlrt_allocate_tree(call->structure, &memory);
    const int32_t status = made ? fill_tree(meshes, mesh_count, call, made) : MLRT_ERROR_OUT_OF_MEMORY;
    if (status != MLRT_OK) {
        note_failure(call, made ? &made->memory : &memory, status);
        mlrt_destroy_tree(made);
        return status;
    }
    made->info.struct_size = sizeof made->info;
    made->info.structure = call->structure->code;
    made->info.triangle_count = made->triangle_count;
    made->info.memory_size = made->memory.held_size;
    made->info.peak_memory_size = made->memory.peak_size;
    made->info.build_seconds = mlrt_seconds_now() - start;
    made->memory.limit_size = 0;
    log_result(&call->voice, &made->info);
    *tree = made;
    return MLRT_OK;
}

static int32_t build(const mlrt_mesh *meshes, size_t mesh_count, const void *options,
                     const struct mlrt_structure *structure, mlrt_tree **tree)
{
    struct call call;
    if (tree) *tree = NULL;
    int32_t status = take_options(options, structure, &call);
    if (status == MLRT_OK && !tree) status = mlrt_fail_null("tree", 0);
    if (status == MLRT_OK) MLRT_COMPUTE(status = build_tree(meshes, mesh_count, &call, tree));
    return mlrt_end_call(&call.voice, status);
}

MLRT_API int32_t mlrt_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                 mlrt_tree **tree)
{
    return build(meshes, mesh_count, options, &mlrt_structure_bvh, tree);
}

MLRT_API int32_t mlrt_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                   mlrt_tree **tree)
{
    return build(meshes, mesh_count, options, &mlrt_structure_kdtree, tree);
}

/* ---- the finished tree ---- */

MLRT_API void mlrt_destroy_tree(mlrt_tree *tree)
{
    if (!tree) return;
    if (!tree->borrowed) {
        mlrt_free_meshes(tree);
        tree->structure->builder.free(tree);
    }
    struct mlrt_memory memory = tree->memory;
    mlrt_free(&memory, tree, 1, sizeof *tree);
}

MLRT_API int32_t mlrt_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info)
{
    if (!tree || !info) return mlrt_fail_null("tree info", !tree);
    const int32_t status = mlrt_check_result_size(MLRT_STRUCT_TREE_INFO, "info", info);
    if (status == MLRT_OK) mlrt_give_struct(&tree->info, sizeof tree->info, info);
    return status;
}

/* ---- estimates of memory ---- */

static MLRT_NOINLINE void foresee(const struct call *call, uint32_t triangle_count, int have_masks, size_t mesh_count,
                                  mlrt_memory_estimate *estimate)
{
    const uint64_t size = have_masks ? sizeof(uint32_t) : 0;
    const uint64_t always = sizeof(struct mlrt_tree) + triangle_count * size + mesh_count * 3 * sizeof(uint32_t);
    const struct mlrt_demand demand = call->structure->builder.foresee(&call->options, triangle_count);
    estimate->memory_size = always + demand.held_size;
    estimate->peak_memory_size = always + demand.peak_size;
}

static int32_t estimate_memory(const mlrt_mesh *meshes, size_t mesh_count, const void *options,
                               const struct mlrt_structure *structure, mlrt_memory_estimate *estimate)
{
    mlrt_memory_estimate own;
    struct call call;
    uint32_t triangle_count;
    int32_t status = take_options(options, structure, &call);
    if (status == MLRT_OK && !estimate) status = mlrt_fail_null("estimate", 0);
    if (status == MLRT_OK) status = mlrt_check_result_size(MLRT_STRUCT_MEMORY_ESTIMATE, "estimate", estimate);
    if (status == MLRT_OK) status = mlrt_check_meshes(meshes, mesh_count, &triangle_count);
    if (status != MLRT_OK) return mlrt_end_call(&call.voice, status);
    memset(&own, 0, sizeof own);
    MLRT_COMPUTE(foresee(&call, triangle_count, mlrt_have_masks(meshes, mesh_count), mesh_count, &own));
    mlrt_give_struct(&own, sizeof own, estimate);
    return MLRT_OK;
}

MLRT_API int32_t mlrt_estimate_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                    mlrt_memory_estimate *estimate)
{
    return estimate_memory(meshes, mesh_count, options, &mlrt_structure_bvh, estimate);
}

MLRT_API int32_t mlrt_estimate_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                      mlrt_memory_estimate *estimate)
{
    return estimate_memory(meshes, mesh_count, options, &mlrt_structure_kdtree, estimate);
}
