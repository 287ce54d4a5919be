/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>

#include "_cgo_export.h"
#include "bridge.h"

static bridge_outcome end_call(int32_t status)
{
    bridge_outcome outcome = {status, status == MLRT_OK ? NULL : strdup(mlrt_last_message())};
    return outcome;
}

int32_t bridge_has_memory(size_t size)
{
    void *volatile memory = malloc(size); /* volatile: compilers may leave out what is freed at once */
    const int32_t has = memory != NULL;
    free(memory);
    return has;
}

/* The call whose callback this thread runs, or 0. */
static __thread uintptr_t current_call;

uintptr_t bridge_current_call(void)
{
    return current_call;
}

static void log_message(void *user, int32_t level, const char *message)
{
    const uintptr_t outer = current_call;
    current_call = (uintptr_t)user;
    mlrtGoLog(current_call, level, (char *)message);
    current_call = outer;
}

static int32_t report_progress(void *user, double fraction)
{
    const uintptr_t outer = current_call;
    current_call = (uintptr_t)user;
    const int32_t end = mlrtGoProgress(current_call, fraction);
    current_call = outer;
    return end;
}

static int32_t receive_tile(void *user, const mlrt_tile *tile)
{
    const uintptr_t outer = current_call;
    current_call = (uintptr_t)user;
    const int32_t end = mlrtGoTile(current_call, (mlrt_tile *)tile);
    current_call = outer;
    return end;
}

static void *enqueue(void *user, mlrt_task_function function, void *argument)
{
    return (void *)mlrtGoEnqueue((uintptr_t)user, function, argument);
}

static void finish(void *user, void *task)
{
    (void)user;
    mlrtGoFinish((uintptr_t)task);
}

/* The host as the C interface has it, or NULL. */
static const mlrt_host *make_host(bridge_host from, mlrt_host *host)
{
    if (!from.functions) return NULL;
    memset(host, 0, sizeof *host);
    host->struct_size = sizeof *host;
    host->user = (void *)from.call;
    if (from.functions & BRIDGE_LOG) host->log = log_message;
    if (from.functions & BRIDGE_PROGRESS) host->progress = report_progress;
    return host;
}

bridge_outcome bridge_build_tree(const mlrt_mesh *meshes, size_t count, const mlrt_tree_options *options,
                                 bridge_host host, mlrt_tree **tree)
{
    mlrt_host space;
    mlrt_tree_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_build_tree(meshes, count, &with_host, tree));
}

bridge_outcome bridge_build_kdtree(const mlrt_mesh *meshes, size_t count, const mlrt_kdtree_options *options,
                                   bridge_host host, mlrt_tree **tree)
{
    mlrt_host space;
    mlrt_kdtree_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_build_kdtree(meshes, count, &with_host, tree));
}

bridge_outcome bridge_estimate_tree(const mlrt_mesh *meshes, size_t count, const mlrt_tree_options *options,
                                    mlrt_memory_estimate *estimate)
{
    return end_call(mlrt_estimate_tree(meshes, count, options, estimate));
}

bridge_outcome bridge_estimate_kdtree(const mlrt_mesh *meshes, size_t count, const mlrt_kdtree_options *options,
                                      mlrt_memory_estimate *estimate)
{
    return end_call(mlrt_estimate_kdtree(meshes, count, options, estimate));
}

bridge_outcome bridge_hash_geometry(const mlrt_mesh *meshes, size_t count, uint64_t *hash)
{
    return end_call(mlrt_hash_geometry(meshes, count, hash));
}

bridge_outcome bridge_load_tree(const void *data, size_t size, const mlrt_load_options *options, bridge_host host,
                                mlrt_tree **tree)
{
    mlrt_host space;
    mlrt_load_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_load_tree(data, size, &with_host, tree));
}

bridge_outcome bridge_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size)
{
    return end_call(mlrt_save_tree(tree, buffer, capacity, size));
}

bridge_outcome bridge_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info)
{
    return end_call(mlrt_get_tree_info(tree, info));
}

bridge_outcome bridge_create_pool(uint32_t threads, mlrt_pool **pool)
{
    return end_call(mlrt_create_pool(threads, pool));
}

bridge_outcome bridge_create_pool_with_executor(uint32_t jobs, uintptr_t executor, mlrt_pool **pool)
{
    mlrt_pool_options options = {.struct_size = sizeof options, .thread_count = jobs};
    options.user = (void *)executor;
    options.enqueue = enqueue;
    options.finish = finish;
    return end_call(mlrt_create_pool_with_options(&options, pool));
}

void bridge_run(mlrt_task_function function, void *argument)
{
    function(argument);
}

bridge_outcome bridge_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   bridge_host host, const mlrt_hits *hits)
{
    mlrt_host space;
    mlrt_trace_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_trace_packet(tree, rays, &with_host, hits));
}

bridge_outcome bridge_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit)
{
    return end_call(mlrt_trace_ray(tree, ray, options, hit));
}

bridge_outcome bridge_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                     bridge_host host, const mlrt_hit_lists *lists)
{
    mlrt_host space;
    mlrt_trace_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_trace_all_hits(tree, rays, &with_host, lists));
}

bridge_outcome bridge_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                                   bridge_host host, const mlrt_hits *frame, uintptr_t call_with_tile)
{
    mlrt_host space;
    mlrt_trace_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_render_tiles(tree, camera, &with_host, frame, call_with_tile ? receive_tile : NULL,
                                      (void *)call_with_tile));
}

bridge_outcome bridge_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions)
{
    return end_call(mlrt_camera_rays(camera, origins, directions));
}

bridge_outcome bridge_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                      const mlrt_trace_options *options, bridge_host host, const mlrt_array *occluded)
{
    mlrt_host space;
    mlrt_trace_options with_host = *options;
    with_host.host = make_host(host, &space);
    return end_call(mlrt_occluded_points(tree, points, light, &with_host, occluded));
}

bridge_outcome bridge_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit,
                                 const mlrt_light *light, mlrt_ray *shadow, int32_t *faces)
{
    return end_call(mlrt_shadow_ray(tree, ray, hit, light, shadow, faces));
}

bridge_outcome bridge_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float *point)
{
    return end_call(mlrt_offset_point(tree, mesh, triangle, u, v, side, point));
}
