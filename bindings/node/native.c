/* SPDX-License-Identifier: MIT */
/*
 * native.c - calls of mlrt.h as Node's promises need them: on a thread of Node's pool, watched from JavaScript
 *
 * A call that runs on another thread can't call JavaScript. So JavaScript and the call share a block of memory, `struct
 * watch`: the call writes its progress, JavaScript reads it by a timer, and writes `cancel` to end the call. What the
 * call logs, and why it fails, is written to the same block before it returns, since mlrt_last_message is that of the
 * thread. index.js has the same layout. Nothing here waits for JavaScript, which may have ended: tiles are copied, and
 * JavaScript fetches them by the same timer.
 *
 * Compiled with mlrt.c, the whole library in one file, or linked with an installed libmlrt (build.js).
 */
#include "mlrt.h"

#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 512, LOG_SIZE = 4096 };

/* A copy of a tile, whose arrays lie behind it. */
struct waiting_tile {
    mlrt_tile tile;
    struct waiting_tile *next;
};

struct watch {
    int32_t progress;           /* written by the call: 0..2^30, the part that is done */
    int32_t cancel;             /* written by JavaScript: 1 = end the call */
    uint32_t log_size;          /* bytes used in `log` */
    uint32_t reserved;          /* 0 */
    char message[MESSAGE_SIZE]; /* why the call failed; terminated; "" if it didn't */
    char log[LOG_SIZE]; /* lines: a digit, MLRT_LOG_*, the text, a newline. Lines that do not fit are left out */
    struct waiting_tile *newest; /* written by the call: a list of tiles, the last one first */
    struct waiting_tile *oldest; /* of JavaScript's thread: a list of those that came before, the first one first */
    int32_t no_memory;           /* written by the call: 1 = there was none for a tile */
};

static int32_t write_progress(void *user, double fraction)
{
    struct watch *watch = user;
    __atomic_store_n(&watch->progress, (int32_t)(fraction * (1 << 30)), __ATOMIC_RELAXED);
    return __atomic_load_n(&watch->cancel, __ATOMIC_RELAXED);
}

static void write_log(void *user, int32_t level, const char *message)
{
    struct watch *watch = user;
    size_t length = strlen(message);
    if (length + 2 > LOG_SIZE - watch->log_size) return;
    char *line = watch->log + watch->log_size;
    line[0] = (char)('0' + level);
    memcpy(line + 1, message, length);
    line[length + 1] = '\n';
    watch->log_size += (uint32_t)length + 2;
}

static mlrt_host watching_host(struct watch *watch)
{
    return (mlrt_host){sizeof(mlrt_host), 0, watch, NULL, NULL, write_log, write_progress};
}

/* Copies an array to *end, and moves *end behind it. */
static const void *copy_array(char **end, const void *from, size_t size)
{
    if (!from) return NULL;
    void *copy = memcpy(*end, from, size);
    *end += size;
    return copy;
}

static int32_t keep_tile(void *user, const mlrt_tile *tile)
{
    struct watch *watch = user;
    size_t pixels = (size_t)tile->width * tile->height;
    size_t words = (size_t) !!tile->t + !!tile->u + !!tile->v + !!tile->mesh + !!tile->triangle + !!tile->facing;
    struct waiting_tile *copy = malloc(sizeof *copy + 4 * pixels * words + (tile->occluded ? pixels : 0));
    if (!copy) {
        __atomic_store_n(&watch->no_memory, 1, __ATOMIC_RELAXED);
        return 1;
    }
    char *end = (char *)(copy + 1);
    copy->tile = *tile;
    copy->tile.t = copy_array(&end, tile->t, 4 * pixels);
    copy->tile.u = copy_array(&end, tile->u, 4 * pixels);
    copy->tile.v = copy_array(&end, tile->v, 4 * pixels);
    copy->tile.mesh = copy_array(&end, tile->mesh, 4 * pixels);
    copy->tile.triangle = copy_array(&end, tile->triangle, 4 * pixels);
    copy->tile.facing = copy_array(&end, tile->facing, 4 * pixels);
    copy->tile.occluded = copy_array(&end, tile->occluded, pixels);
    copy->next = __atomic_load_n(&watch->newest, __ATOMIC_RELAXED);
    while (!__atomic_compare_exchange_n(&watch->newest, &copy->next, copy, 1, __ATOMIC_RELEASE, __ATOMIC_RELAXED)) {
    }
    return __atomic_load_n(&watch->cancel, __ATOMIC_RELAXED);
}

/* Returns `status`, after the reason for it has been written to the block. */
static int32_t explain(int32_t status, struct watch *watch)
{
    if (status != MLRT_OK) strncat(watch->message, mlrt_last_message(), MESSAGE_SIZE - 1);
    return status;
}

/*
 * The functions below are those of mlrt.h without `node`. The caller's options, never NULL, have no host: theirs is the
 * one above.
 */

MLRT_API uint32_t mlrt_node_watch_size(void);
uint32_t mlrt_node_watch_size(void)
{
    return sizeof(struct watch);
}

/* Returns the next tile of a render, or NULL if none waits. JavaScript's thread has it until mlrt_node_free_tile. */
MLRT_API mlrt_tile *mlrt_node_next_tile(struct watch *watch);
mlrt_tile *mlrt_node_next_tile(struct watch *watch)
{
    if (!watch->oldest) {
        struct waiting_tile *tile = __atomic_exchange_n(&watch->newest, NULL, __ATOMIC_ACQUIRE);
        while (tile) {
            struct waiting_tile *before = tile->next;
            tile->next = watch->oldest;
            watch->oldest = tile;
            tile = before;
        }
    }
    struct waiting_tile *tile = watch->oldest;
    if (!tile) return NULL;
    watch->oldest = tile->next;
    return &tile->tile;
}

MLRT_API void mlrt_node_free_tile(mlrt_tile *tile);
void mlrt_node_free_tile(mlrt_tile *tile)
{
    free(tile); /* the first member of what was allocated */
}

MLRT_API int32_t mlrt_node_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                      mlrt_tree **tree, struct watch *watch);
int32_t mlrt_node_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                             mlrt_tree **tree, struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_tree_options watched = *options;
    watched.host = &host;
    return explain(mlrt_build_tree(meshes, mesh_count, &watched, tree), watch);
}

MLRT_API int32_t mlrt_node_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                        mlrt_tree **tree, struct watch *watch);
int32_t mlrt_node_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                               mlrt_tree **tree, struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_kdtree_options watched = *options;
    watched.host = &host;
    return explain(mlrt_build_kdtree(meshes, mesh_count, &watched, tree), watch);
}

MLRT_API int32_t mlrt_node_load_tree(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree,
                                     struct watch *watch);
int32_t mlrt_node_load_tree(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree,
                            struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_load_options watched = *options;
    watched.host = &host;
    return explain(mlrt_load_tree(data, size, &watched, tree), watch);
}

MLRT_API int32_t mlrt_node_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size,
                                     struct watch *watch);
int32_t mlrt_node_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size, struct watch *watch)
{
    return explain(mlrt_save_tree(tree, buffer, capacity, size), watch);
}

MLRT_API int32_t mlrt_node_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                        const mlrt_hits *hits, struct watch *watch);
int32_t mlrt_node_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                               const mlrt_hits *hits, struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_trace_options watched = *options;
    watched.host = &host;
    return explain(mlrt_trace_packet(tree, rays, &watched, hits), watch);
}

MLRT_API int32_t mlrt_node_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays,
                                          const mlrt_trace_options *options, const mlrt_hit_lists *lists,
                                          struct watch *watch);
int32_t mlrt_node_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                 const mlrt_hit_lists *lists, struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_trace_options watched = *options;
    watched.host = &host;
    return explain(mlrt_trace_all_hits(tree, rays, &watched, lists), watch);
}

/* `tiles`: 1 = keep a copy of each tile for mlrt_node_next_tile. */
MLRT_API int32_t mlrt_node_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera,
                                        const mlrt_trace_options *options, const mlrt_hits *frame, int32_t tiles,
                                        struct watch *watch);
int32_t mlrt_node_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                               const mlrt_hits *frame, int32_t tiles, struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_trace_options watched = *options;
    watched.host = &host;
    int32_t status = mlrt_render_tiles(tree, camera, &watched, frame, tiles ? keep_tile : NULL, watch);
    return watch->no_memory ? MLRT_ERROR_OUT_OF_MEMORY : explain(status, watch);
}

MLRT_API int32_t mlrt_node_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                           const mlrt_trace_options *options, const mlrt_array *occluded,
                                           struct watch *watch);
int32_t mlrt_node_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                  const mlrt_trace_options *options, const mlrt_array *occluded, struct watch *watch)
{
    mlrt_host host = watching_host(watch);
    mlrt_trace_options watched = *options;
    watched.host = &host;
    return explain(mlrt_occluded_points(tree, points, light, &watched, occluded), watch);
}
