/* SPDX-License-Identifier: MIT */
/*
 * The C interface for cgo. Goroutines change threads between calls, so each function here also fetches the message of the
 * call that it makes. Callbacks come back through functions that Go exports, with handles in place of pointers.
 */
#ifndef MLRT_GO_BRIDGE_H
#define MLRT_GO_BRIDGE_H

#if defined(MLRT_SYSTEM)
#include <mlrt.h>
#elif __has_include("mlrt.h")
#include "mlrt.h"
#else
#error "mlrt: the C library is not here, as this is a checkout and no released module: run `make package-go` in the repository and use build/packages/go, or build with -tags mlrt_system after `make install`"
#endif

/* The message is NULL after MLRT_OK, and else to be freed. */
typedef struct bridge_outcome {
    int32_t status;
    char *message;
} bridge_outcome;

/* The functions of a host that Go wants called: BRIDGE_LOG, BRIDGE_PROGRESS or both; 0 = no host. */
enum { BRIDGE_LOG = 1, BRIDGE_PROGRESS = 2 };

typedef struct bridge_host {
    uintptr_t call; /* handle of a *call */
    int32_t functions;
} bridge_host;

/* Whether the system has so many bytes, which Go, without asking, would end the program for. */
int32_t bridge_has_memory(size_t size);

/* The handle of the call whose callback this thread runs; 0 = none. */
uintptr_t bridge_current_call(void);

bridge_outcome bridge_build_tree(const mlrt_mesh *meshes, size_t count, const mlrt_tree_options *options,
                                 bridge_host host, mlrt_tree **tree);
bridge_outcome bridge_build_kdtree(const mlrt_mesh *meshes, size_t count, const mlrt_kdtree_options *options,
                                   bridge_host host, mlrt_tree **tree);
bridge_outcome bridge_estimate_tree(const mlrt_mesh *meshes, size_t count, const mlrt_tree_options *options,
                                    mlrt_memory_estimate *estimate);
bridge_outcome bridge_estimate_kdtree(const mlrt_mesh *meshes, size_t count, const mlrt_kdtree_options *options,
                                      mlrt_memory_estimate *estimate);
bridge_outcome bridge_hash_geometry(const mlrt_mesh *meshes, size_t count, uint64_t *hash);
bridge_outcome bridge_load_tree(const void *data, size_t size, const mlrt_load_options *options, bridge_host host,
                                mlrt_tree **tree);
bridge_outcome bridge_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size);
bridge_outcome bridge_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info);

bridge_outcome bridge_create_pool(uint32_t threads, mlrt_pool **pool);
bridge_outcome bridge_create_pool_with_executor(uint32_t jobs, uintptr_t executor, mlrt_pool **pool);
void bridge_run(mlrt_task_function function, void *argument);

bridge_outcome bridge_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   bridge_host host, const mlrt_hits *hits);
bridge_outcome bridge_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit);
bridge_outcome bridge_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                     bridge_host host, const mlrt_hit_lists *lists);
bridge_outcome bridge_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                                   bridge_host host, const mlrt_hits *frame, uintptr_t call_with_tile);
bridge_outcome bridge_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions);
bridge_outcome bridge_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                      const mlrt_trace_options *options, bridge_host host, const mlrt_array *occluded);
bridge_outcome bridge_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit,
                                 const mlrt_light *light, mlrt_ray *shadow, int32_t *faces);
bridge_outcome bridge_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float *point);

#endif
