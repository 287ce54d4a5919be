/* SPDX-License-Identifier: MIT */
/* loaded_library.h - the functions of a build of the library: that of this program, or another shared object */
#ifndef LOADED_LIBRARY_H
#define LOADED_LIBRARY_H

#include <mlrt.h>

struct library {
    void *handle; /* NULL = that of this program */
    int32_t (*create_pool)(uint32_t thread_count, mlrt_pool **pool);
    void (*destroy_pool)(mlrt_pool *pool);
    int32_t (*build_tree)(
        const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
        mlrt_tree **tree); /* NULL: a build from before it; build_kdtree without options builds boxes */
    int32_t (*build_kdtree)(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                            mlrt_tree **tree);
    int32_t (*save_tree)(const mlrt_tree *tree, void *buffer, size_t capacity,
                         size_t *size); /* NULL: a build from before it */
    void (*destroy_tree)(mlrt_tree *tree);
    int32_t (*trace_ray)(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options, mlrt_hit *hit);
    int32_t (*trace_packet)(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                            const mlrt_hits *hits);
    int32_t (*render_tiles)(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                            const mlrt_hits *frame, mlrt_tile_callback callback, void *user);
    int32_t (*occluded_points)(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                               const mlrt_trace_options *options, const mlrt_array *occluded);
};

extern const struct library this_library;

/* Loads a shared object. Returns 0, or 1 after a message on stderr. */
int load_library(const char *path, struct library *library);
void close_library(struct library *library);

#endif
