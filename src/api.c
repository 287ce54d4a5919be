/* SPDX-License-Identifier: MIT */
/*
 * The exported functions: each checks its arguments, resolves its options, enters the floating-point environment of the
 * library, and calls one internal function that does the work.
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "all_hits.h"
#include "bvh_build.h"
#include "dispatch.h"
#include "kdtree_build.h"
#include "offset.h"
#include "render.h"
#include "trace_ray.h"

#define TRIANGLE_LIMIT ((1u << 30) - 1) /* leaves count in 30 bits */

#define DEFAULT_INITIAL_TILE        128
#define DEFAULT_TILE_ROWS           64  /* of the tile method, for arrays with rows */
#define DEFAULT_TILE_LIST           256 /* and for lists, which are four wide */
#define DEFAULT_INITIAL_TILE_ARRAYS 32  /* beams of arrays are made by looking at every ray: on one level only */
#define DEFAULT_MINIMUM_TILE        16
#define DEFAULT_SPLIT_FACTOR        16

MLRT_API uint32_t mlrt_version(void)
{
    return MLRT_VERSION_MAJOR * 10000 + MLRT_VERSION_MINOR * 100 + MLRT_VERSION_PATCH;
}

MLRT_API const char *mlrt_status_string(int32_t status)
{
    static const char *const texts[] = {
        "ok",
        "invalid argument",
        "struct_size is not set or not of any version",
        "a triangle names a vertex that does not exist",
        "out of memory",
        "more triangles, rays or pixels than 32-bit counts allow",
        "camera of size zero, crop outside of it, numbers that are not finite, or vectors that span no picture",
        "instruction set not available here, or a method for a structure that the tree does not have",
        "the system would not start a thread",
        "stopped by a callback",
    };
    const int32_t count = (int32_t)(sizeof texts / sizeof *texts);
    return status >= 0 && status < count ? texts[status] : "unknown status";
}

/* ---- building ---- */

static void write_message(const mlrt_build_options *options, const char *format, unsigned long a, unsigned long b,
                          unsigned long c, unsigned long d)
{
    if (options && options->message && options->message_size) {
        snprintf(options->message, options->message_size, format, a, b, c, d);
    }
}

static const mlrt_mesh *mesh_at(const mlrt_mesh *meshes, size_t i)
{
    return (const mlrt_mesh *)(const void *)((const unsigned char *)meshes + i * meshes->struct_size);
}

static int32_t check_mesh(const mlrt_mesh *mesh)
{
    if (mesh->struct_size != sizeof *mesh) return MLRT_ERROR_STRUCT_SIZE;
    const uint32_t index_size = mesh->index_size ? mesh->index_size : 4;
    if ((index_size != 2 && index_size != 4) || mesh->reserved != 0) return MLRT_ERROR_ARGUMENT;
    if (mesh->triangle_count == 0) return MLRT_OK;
    if (mesh->triangle_count > TRIANGLE_LIMIT) return MLRT_ERROR_TOO_LARGE;
    if (!mesh->vertices && mesh->vertex_count) return MLRT_ERROR_ARGUMENT;
    if (mesh->vertex_stride % 4 || (mesh->vertex_stride && mesh->vertex_stride < 12)) return MLRT_ERROR_ARGUMENT;
    if ((uintptr_t)mesh->vertices % 4 || (uintptr_t)mesh->indices % index_size) return MLRT_ERROR_ARGUMENT;
    if (mesh->triangle_stride % index_size || (mesh->triangle_stride && mesh->triangle_stride < 3 * index_size)) {
        return MLRT_ERROR_ARGUMENT;
    }
    return MLRT_OK;
}

/* Vertex number `corner` of a triangle. */
static uint64_t vertex_index(const mlrt_mesh *mesh, size_t triangle, int corner)
{
    if (!mesh->indices) return (uint64_t)triangle * 3 + (uint64_t)corner;
    const uint32_t index_size = mesh->index_size ? mesh->index_size : 4;
    const size_t stride = mesh->triangle_stride ? mesh->triangle_stride : 3 * (size_t)index_size;
    const unsigned char *triple = (const unsigned char *)mesh->indices + triangle * stride;
    if (index_size == 2) return ((const uint16_t *)(const void *)triple)[corner];
    return ((const uint32_t *)(const void *)triple)[corner];
}

static int32_t copy_triangles(const mlrt_mesh *mesh, size_t position, const mlrt_build_options *options,
                              struct mlrt_triangle *triangles)
{
    const size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        for (int corner = 0; corner < 3; ++corner) {
            const uint64_t index = vertex_index(mesh, i, corner);
            if (index >= mesh->vertex_count) {
                write_message(options, "mesh %lu, triangle %lu: vertex index %lu is out of range (vertex_count is %lu)",
                              (unsigned long)position, (unsigned long)i, (unsigned long)index,
                              (unsigned long)mesh->vertex_count);
                return MLRT_ERROR_INDEX_RANGE;
            }
            memcpy(triangles[i].v[corner], (const unsigned char *)mesh->vertices + (size_t)index * stride, 12);
        }
    }
    return MLRT_OK;
}

static int32_t check_build_options(const mlrt_build_options *options)
{
    if (!options) return MLRT_OK;
    if (options->struct_size != sizeof *options) return MLRT_ERROR_STRUCT_SIZE;
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
    const uint32_t given = options ? options->structures : 0;
    if (options && options->preset == MLRT_TREE_PAPER) return given | MLRT_STRUCTURE_KDTREE;
    return given ? given : MLRT_STRUCTURE_BVH;
}

static int compare_ids(const void *a, const void *b)
{
    const uint32_t *first = a, *second = b;
    return (*first > *second) - (*first < *second);
}

/* Sets the id tables of a tree: ids as given, or positions if all are 0. */
static int32_t set_mesh_ids(const mlrt_mesh *meshes, size_t mesh_count, struct mlrt_tree *tree)
{
    int all_zero = 1;
    for (size_t i = 0; i < mesh_count; ++i) all_zero &= mesh_at(meshes, i)->id == 0;

    struct id_and_position {
        uint32_t id;
        uint32_t position;
    } *sorted = mlrt_allocate(&tree->memory, mesh_count, sizeof *sorted);
    if (!sorted) return MLRT_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < mesh_count; ++i) {
        tree->mesh_ids[i] = all_zero ? (uint32_t)i : mesh_at(meshes, i)->id;
        sorted[i].id = tree->mesh_ids[i];
        sorted[i].position = (uint32_t)i;
    }
    qsort(sorted, mesh_count, sizeof *sorted, compare_ids);
    int32_t status = MLRT_OK;
    for (size_t i = 0; i < mesh_count; ++i) {
        tree->mesh_by_id[i] = sorted[i].position;
        if (sorted[i].id == MLRT_NONE || (i > 0 && sorted[i].id == sorted[i - 1].id)) status = MLRT_ERROR_ARGUMENT;
    }
    mlrt_free(&tree->memory, sorted, mesh_count, sizeof *sorted);
    return status;
}

static int32_t fill_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_build_options *options,
                         struct mlrt_tree *tree)
{
    uint64_t triangle_count = 0;
    for (size_t i = 0; i < mesh_count; ++i) {
        int32_t status = check_mesh(mesh_at(meshes, i));
        if (status != MLRT_OK) return status;
        triangle_count += mesh_at(meshes, i)->triangle_count;
        if (triangle_count > TRIANGLE_LIMIT) return MLRT_ERROR_TOO_LARGE;
    }
    tree->mesh_count = (uint32_t)mesh_count;
    tree->triangle_count = (uint32_t)triangle_count;
    tree->mesh_ids = mlrt_allocate(&tree->memory, mesh_count, sizeof *tree->mesh_ids);
    tree->mesh_by_id = mlrt_allocate(&tree->memory, mesh_count, sizeof *tree->mesh_by_id);
    tree->mesh_first = mlrt_allocate(&tree->memory, mesh_count + 1, sizeof *tree->mesh_first);
    tree->triangles = mlrt_allocate(&tree->memory, tree->triangle_count, sizeof *tree->triangles);
    if (!tree->mesh_ids || !tree->mesh_by_id || !tree->mesh_first || !tree->triangles) return MLRT_ERROR_OUT_OF_MEMORY;

    int32_t status = set_mesh_ids(meshes, mesh_count, tree);
    if (status != MLRT_OK) return status;
    tree->mesh_first[0] = 0;
    for (size_t i = 0; i < mesh_count; ++i) {
        const mlrt_mesh *mesh = mesh_at(meshes, i);
        status = copy_triangles(mesh, i, options, tree->triangles + tree->mesh_first[i]);
        if (status != MLRT_OK) return status;
        tree->mesh_first[i + 1] = tree->mesh_first[i] + (uint32_t)mesh->triangle_count;
    }
    tree->structures = resolve_structures(options);
    if (tree->structures & MLRT_STRUCTURE_KDTREE) status = mlrt_build_nodes(tree, options);
    if (status == MLRT_OK && tree->structures & MLRT_STRUCTURE_BVH) status = mlrt_build_bvh(tree, options);
    return status;
}

static double seconds_now(void)
{
    struct timespec now;
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0) return 0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static MLRT_NOINLINE int32_t build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_build_options *options,
                                        mlrt_tree **tree)
{
    const double start = seconds_now();
    struct mlrt_tree *made = calloc(1, sizeof *made);
    if (!made) return MLRT_ERROR_OUT_OF_MEMORY;
    int32_t status = fill_tree(meshes, mesh_count, options, made);
    if (status != MLRT_OK) {
        mlrt_destroy_tree(made);
        return status;
    }
    made->info.struct_size = sizeof made->info;
    made->info.triangle_count = made->triangle_count;
    made->info.memory_size = made->memory.held_size + sizeof *made;
    made->info.peak_memory_size = made->memory.peak_size + sizeof *made;
    made->info.build_seconds = seconds_now() - start;
    *tree = made;
    return MLRT_OK;
}

MLRT_API int32_t mlrt_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_build_options *options,
                                   mlrt_tree **tree)
{
    if (!tree) return MLRT_ERROR_ARGUMENT;
    *tree = NULL;
    if (!meshes && mesh_count) return MLRT_ERROR_ARGUMENT;
    if (mesh_count > INT32_MAX) return MLRT_ERROR_TOO_LARGE;
    if (mesh_count && meshes->struct_size != sizeof *meshes) return MLRT_ERROR_STRUCT_SIZE;
    int32_t status = check_build_options(options);
    if (status != MLRT_OK) return status;
    write_message(options, "", 0, 0, 0, 0);

    const uint64_t environment = mlrt_enter_fp_environment();
    status = build_tree(meshes, mesh_count, options, tree);
    mlrt_leave_fp_environment(environment);
    return status;
}

MLRT_API void mlrt_destroy_tree(mlrt_tree *tree)
{
    if (!tree) return;
    mlrt_free(&tree->memory, tree->triangles, tree->triangle_count, sizeof *tree->triangles);
    mlrt_free(&tree->memory, tree->mesh_ids, tree->mesh_count, sizeof *tree->mesh_ids);
    mlrt_free(&tree->memory, tree->mesh_by_id, tree->mesh_count, sizeof *tree->mesh_by_id);
    mlrt_free(&tree->memory, tree->mesh_first, (size_t)tree->mesh_count + 1, sizeof *tree->mesh_first);
    mlrt_free_bvh(tree);
    mlrt_free(&tree->memory, tree->nodes, tree->node_count, sizeof *tree->nodes);
    mlrt_free(&tree->memory, tree->references, tree->reference_count, sizeof *tree->references);
    free(tree);
}

MLRT_API int32_t mlrt_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info)
{
    if (!tree || !info) return MLRT_ERROR_ARGUMENT;
    if (info->struct_size != sizeof *info) return MLRT_ERROR_STRUCT_SIZE;
    *info = tree->info;
    return MLRT_OK;
}

/* ---- tracing ---- */

static int is_power_of_two(uint32_t n)
{
    return n != 0 && (n & (n - 1)) == 0;
}

/* The default, or what was given if it is a power of two in lo..hi; 0 if it is not. */
static uint32_t resolve_size(uint32_t given, uint32_t standard, uint32_t lo, uint32_t hi)
{
    if (given == 0) return standard;
    return is_power_of_two(given) && given >= lo && given <= hi ? given : 0;
}

/* A method, with the default resolved; MLRT_METHOD_DEFAULT if the tree lacks what the method searches in. */
static int32_t resolve_method(int32_t method, const struct mlrt_tree *tree)
{
    const int has_boxes = (tree->structures & MLRT_STRUCTURE_BVH) != 0;
    const int has_kdtree = (tree->structures & MLRT_STRUCTURE_KDTREE) != 0;
    if (method == MLRT_METHOD_DEFAULT) return has_boxes ? MLRT_METHOD_TILE : MLRT_METHOD_MULTILEVEL;
    if (method == MLRT_METHOD_TILE) return has_boxes ? method : MLRT_METHOD_DEFAULT;
    return has_kdtree || method == MLRT_METHOD_RAY ? method : MLRT_METHOD_DEFAULT;
}

/* The side of the tiles that are shared out among threads. */
static uint32_t standard_initial_tile(const struct mlrt_job *job)
{
    if (job->source.kind == MLRT_SOURCE_CAMERA) return DEFAULT_INITIAL_TILE;
    if (job->method != MLRT_METHOD_TILE) return DEFAULT_INITIAL_TILE_ARRAYS;
    return job->source.width <= 4 ? DEFAULT_TILE_LIST : DEFAULT_TILE_ROWS;
}

/* Checks options and puts what they say into a job whose source is set. */
static int32_t resolve_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    static const mlrt_trace_options standard = {.struct_size = sizeof standard};
    if (!options) options = &standard;
    if (options->struct_size != sizeof *options) return MLRT_ERROR_STRUCT_SIZE;
    if (options->query != MLRT_QUERY_CLOSEST && options->query != MLRT_QUERY_ANY) return MLRT_ERROR_ARGUMENT;
    if (options->method < MLRT_METHOD_DEFAULT || options->method > MLRT_METHOD_TILE) return MLRT_ERROR_ARGUMENT;
    if (options->isa < MLRT_ISA_AUTO || options->isa > MLRT_ISA_AVX512) return MLRT_ERROR_ARGUMENT;
    if (options->culling != MLRT_CULLING_INVERSE && options->culling != MLRT_CULLING_DIRECT) return MLRT_ERROR_ARGUMENT;
    if (options->reserved != 0 || options->culling_check > 1 || options->shortcuts_off & ~7u || options->outputs & ~31u)
        return MLRT_ERROR_ARGUMENT;
    if (options->split_factor != 0 && options->split_factor != 4 && options->split_factor != 16) {
        return MLRT_ERROR_ARGUMENT;
    }
    if (options->counters && options->counters->struct_size != sizeof *options->counters) return MLRT_ERROR_STRUCT_SIZE;

    job->any = options->query == MLRT_QUERY_ANY;
    job->method = resolve_method(options->method, tree);
    if (job->method == MLRT_METHOD_DEFAULT) return MLRT_ERROR_UNSUPPORTED;
    job->culling = options->culling;
    job->culling_check = options->culling_check != 0;
    const uint32_t shortcuts = job->method == MLRT_METHOD_MULTILEVEL ? ~options->shortcuts_off : 0;
    job->whole_tiles = (shortcuts & MLRT_SHORTCUT_WHOLE_TILES) != 0;
    job->entry_lists = (shortcuts & MLRT_SHORTCUT_ENTRY_LISTS) != 0;
    job->shared_setups = (shortcuts & MLRT_SHORTCUT_SHARED_SETUPS) != 0;
    job->initial_tile_size = resolve_size(options->initial_tile_size, standard_initial_tile(job), 4, 1024);
    uint32_t standard_minimum =
        job->source.kind == MLRT_SOURCE_CAMERA ? DEFAULT_MINIMUM_TILE : DEFAULT_INITIAL_TILE_ARRAYS;
    if (standard_minimum > job->initial_tile_size) standard_minimum = job->initial_tile_size;
    job->minimum_tile_size = resolve_size(options->minimum_tile_size, standard_minimum, 4, job->initial_tile_size);
    if (!job->initial_tile_size || !job->minimum_tile_size) return MLRT_ERROR_ARGUMENT;
    const uint32_t split_factor = options->split_factor ? options->split_factor : DEFAULT_SPLIT_FACTOR;
    job->split_divisor = split_factor == 4 ? 2 : 4;
    job->outputs = options->outputs;
    job->kernels = mlrt_select_kernels(options->isa, job->method, options->counters != NULL);
    return job->kernels ? MLRT_OK : MLRT_ERROR_UNSUPPORTED;
}

static mlrt_pool *pool_of(const mlrt_trace_options *options)
{
    return options ? options->pool : NULL;
}

static mlrt_counters *counters_of(const mlrt_trace_options *options)
{
    return options ? options->counters : NULL;
}

static MLRT_NOINLINE int32_t make_packet_job(const mlrt_tree *tree, const mlrt_rays *rays,
                                             const mlrt_trace_options *options, const mlrt_hits *hits,
                                             struct mlrt_job *job)
{
    int32_t status = mlrt_make_ray_source(tree, rays, &job->source);
    if (status == MLRT_OK) status = resolve_options(tree, options, job);
    if (status == MLRT_OK) status = mlrt_make_sink(hits, job->any, job->source.width, 1, &job->frame);
    job->tree = tree;
    job->has_frame = 1;
    return status;
}

MLRT_API int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   const mlrt_hits *hits)
{
    if (!tree || !rays || !hits) return MLRT_ERROR_ARGUMENT;
    if (rays->struct_size != sizeof *rays || hits->struct_size != sizeof *hits) return MLRT_ERROR_STRUCT_SIZE;
    struct mlrt_job job = {.callback = NULL};
    const uint64_t environment = mlrt_enter_fp_environment();
    const int32_t status = make_packet_job(tree, rays, options, hits, &job);
    mlrt_leave_fp_environment(environment);
    return status == MLRT_OK ? mlrt_run_job(&job, pool_of(options), counters_of(options)) : status;
}

/* Writes what a ray hit to the caller's struct; `number` is MLRT_NONE for a miss. */
static void write_hit(const mlrt_tree *tree, const struct mlrt_ray_segment *segment, uint32_t number, int any,
                      mlrt_hit *hit)
{
    hit->occluded = number != MLRT_NONE;
    if (any) return;
    struct mlrt_hit_report report = {INFINITY, 0, 0, 0};
    mlrt_find_ids(tree, number, &hit->mesh, &hit->triangle);
    if (number != MLRT_NONE) {
        mlrt_report_hit(segment, &tree->triangles[number], MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_FACING,
                        &report);
    }
    hit->t = report.t;
    hit->u = report.u;
    hit->v = report.v;
    hit->facing = report.facing;
}

/* By the kernel for rays that go alone, if that is the method and it can, or else by method `ray`. */
static uint32_t trace_segment(const struct mlrt_job *job, const struct mlrt_ray_segment *segment, uint32_t skip,
                              mlrt_counters *counters)
{
    if (job->method == MLRT_METHOD_TILE && job->kernels->trace_ray && job->tree->bvh.float_safe &&
        mlrt_is_safe_ray(segment)) {
        return job->kernels->trace_ray(job, segment, skip);
    }
    return mlrt_trace_segment(job->tree, segment, skip, job->any, counters);
}

/* One ray: nothing to set up. */
static MLRT_NOINLINE void trace_directly(const struct mlrt_job *job, const mlrt_ray *ray, mlrt_counters *counters,
                                         mlrt_hit *hit)
{
    const struct mlrt_tree *tree = job->tree;
    struct mlrt_ray_segment segment;
    uint32_t number = MLRT_NONE;
    const uint32_t skip =
        ray->flags & MLRT_RAY_SKIP ? mlrt_triangle_number(tree, ray->skip_mesh, ray->skip_triangle) : MLRT_NONE;
    if (counters) ++counters->ray_count;
    if (mlrt_make_segment(ray->origin, ray->direction, ray->t_min, ray->t_max == 0 ? INFINITY : ray->t_max, &segment)) {
        if (counters) ++counters->packet_count;
        number = trace_segment(job, &segment, skip, counters);
    }
    write_hit(tree, &segment, number, job->any, hit);
}

/* Any other method: a list of one ray. The arrays are the caller's struct. */
static int32_t trace_as_list(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options, int any,
                             mlrt_hit *hit)
{
    const float t_max = ray->t_max == 0 ? INFINITY : ray->t_max;
    const uint32_t skip[2] = {ray->skip_mesh, ray->skip_triangle};
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = 1,
                            .origins = {ray->origin, 0},
                            .directions = {ray->direction, 0},
                            .t_min = {&ray->t_min, 0},
                            .t_max = {&t_max, 0},
                            .skip = {ray->flags & MLRT_RAY_SKIP ? skip : NULL, 0}};
    uint8_t occluded = 0;
    mlrt_hits hits = {.struct_size = sizeof hits};
    if (any) {
        hits.occluded.data = &occluded;
    } else {
        hits.t.data = &hit->t;
        hits.u.data = &hit->u;
        hits.v.data = &hit->v;
        hits.mesh.data = &hit->mesh;
        hits.triangle.data = &hit->triangle;
        hits.facing.data = &hit->facing;
    }
    const int32_t status = mlrt_trace_packet(tree, &rays, options, &hits);
    if (status == MLRT_OK) hit->occluded = any ? occluded : hit->triangle != MLRT_NONE;
    return status;
}

MLRT_API int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit)
{
    if (!tree || !ray || !hit) return MLRT_ERROR_ARGUMENT;
    if (ray->struct_size != sizeof *ray || hit->struct_size != sizeof *hit) return MLRT_ERROR_STRUCT_SIZE;
    if (ray->flags & ~(uint32_t)MLRT_RAY_SKIP) return MLRT_ERROR_ARGUMENT;
    struct mlrt_job job = {.tree = tree};
    const int32_t status = resolve_options(tree, options, &job);
    if (status != MLRT_OK) return status;
    if (options && options->method != MLRT_METHOD_DEFAULT && options->method != MLRT_METHOD_RAY) {
        return trace_as_list(tree, ray, options, job.any, hit);
    }
    const uint64_t environment = mlrt_enter_fp_environment();
    trace_directly(&job, ray, counters_of(options), hit);
    mlrt_leave_fp_environment(environment);
    return MLRT_OK;
}

static MLRT_NOINLINE int32_t make_list_source(const mlrt_tree *tree, const mlrt_rays *rays,
                                              const mlrt_trace_options *options, struct mlrt_source *source)
{
    struct mlrt_job job = {.callback = NULL};
    const int32_t status = mlrt_make_ray_source(tree, rays, source);
    return status == MLRT_OK ? resolve_options(tree, options, &job) : status;
}

MLRT_API int32_t mlrt_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                     const mlrt_hit_lists *lists)
{
    if (!tree || !rays || !lists) return MLRT_ERROR_ARGUMENT;
    if (rays->struct_size != sizeof *rays || lists->struct_size != sizeof *lists) return MLRT_ERROR_STRUCT_SIZE;
    struct mlrt_source source;
    const uint64_t environment = mlrt_enter_fp_environment();
    const int32_t status = make_list_source(tree, rays, options, &source);
    mlrt_leave_fp_environment(environment);
    return status == MLRT_OK ? mlrt_run_all_hits(tree, &source, lists, pool_of(options), counters_of(options)) : status;
}

static MLRT_NOINLINE int32_t make_render_job(const mlrt_tree *tree, const mlrt_camera *camera,
                                             const mlrt_trace_options *options, const mlrt_hits *frame,
                                             struct mlrt_job *job)
{
    int32_t status = mlrt_make_view_source(camera, &job->source);
    if (status == MLRT_OK) status = resolve_options(tree, options, job);
    if (status == MLRT_OK && frame) {
        status = mlrt_make_sink(frame, job->any, job->source.width, 0, &job->frame);
        job->has_frame = !mlrt_sink_is_empty(&job->frame);
    }
    job->tree = tree;
    return status;
}

MLRT_API int32_t mlrt_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                                   const mlrt_hits *frame, mlrt_tile_callback callback, void *user)
{
    if (!tree || !camera || (!frame && !callback)) return MLRT_ERROR_ARGUMENT;
    if (camera->struct_size != sizeof *camera) return MLRT_ERROR_STRUCT_SIZE;
    if (frame && frame->struct_size != sizeof *frame) return MLRT_ERROR_STRUCT_SIZE;
    struct mlrt_job job = {.callback = callback, .user = user};
    const uint64_t environment = mlrt_enter_fp_environment();
    const int32_t status = make_render_job(tree, camera, options, frame, &job);
    mlrt_leave_fp_environment(environment);
    return status == MLRT_OK ? mlrt_run_job(&job, pool_of(options), counters_of(options)) : status;
}

static int can_write_floats(const mlrt_array *array)
{
    return !array || !array->data ||
           ((uintptr_t)array->data % 4 == 0 && array->stride % 4 == 0 && array->row_stride % 4 == 0);
}

static float *vector_at(const mlrt_array *array, uint32_t width, uint32_t i, uint32_t j)
{
    const size_t stride = array->stride ? array->stride : 12;
    const size_t row_stride = array->row_stride ? array->row_stride : width * stride;
    return (float *)(void *)((unsigned char *)array->data + j * row_stride + i * stride);
}

static MLRT_NOINLINE int32_t write_camera_rays(const mlrt_camera *camera, const mlrt_array *origins,
                                               const mlrt_array *directions)
{
    struct mlrt_view view;
    const int32_t status = mlrt_make_view(camera, &view);
    if (status != MLRT_OK) return status;
    for (uint32_t j = 0; j < view.height; ++j) {
        for (uint32_t i = 0; i < view.width; ++i) {
            float p[3];
            mlrt_view_point(&view, i, j, p);
            if (origins && origins->data) {
                memcpy(vector_at(origins, view.width, i, j), view.parallel ? p : view.eye, sizeof p);
            }
            if (directions && directions->data) {
                memcpy(vector_at(directions, view.width, i, j), view.parallel ? camera->direction : p, sizeof p);
            }
        }
    }
    return MLRT_OK;
}

MLRT_API int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions)
{
    if (!camera || !can_write_floats(origins) || !can_write_floats(directions)) return MLRT_ERROR_ARGUMENT;
    if (camera->struct_size != sizeof *camera) return MLRT_ERROR_STRUCT_SIZE;
    const uint64_t environment = mlrt_enter_fp_environment();
    const int32_t status = write_camera_rays(camera, origins, directions);
    mlrt_leave_fp_environment(environment);
    return status;
}

static MLRT_NOINLINE int32_t make_light_job(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                            const mlrt_trace_options *options, const mlrt_array *occluded,
                                            struct mlrt_job *job)
{
    mlrt_trace_options any = {.struct_size = sizeof any};
    if (options) {
        if (options->struct_size != sizeof *options) return MLRT_ERROR_STRUCT_SIZE;
        any = *options;
    }
    any.query = MLRT_QUERY_ANY;
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = *occluded};
    int32_t status = mlrt_make_light_source(tree, points, light, &job->source);
    if (status == MLRT_OK) status = resolve_options(tree, &any, job);
    if (status == MLRT_OK) status = mlrt_make_sink(&hits, 1, job->source.width, 1, &job->frame);
    job->tree = tree;
    job->has_frame = 1;
    return status;
}

MLRT_API int32_t mlrt_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                      const mlrt_trace_options *options, const mlrt_array *occluded)
{
    if (!tree || !points || !light || !occluded || !occluded->data) return MLRT_ERROR_ARGUMENT;
    if (points->struct_size != sizeof *points || light->struct_size != sizeof *light) return MLRT_ERROR_STRUCT_SIZE;
    struct mlrt_job job = {.callback = NULL};
    const uint64_t environment = mlrt_enter_fp_environment();
    const int32_t status = make_light_job(tree, points, light, options, occluded, &job);
    mlrt_leave_fp_environment(environment);
    return status == MLRT_OK ? mlrt_run_job(&job, pool_of(options), counters_of(options)) : status;
}

MLRT_API int32_t mlrt_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float point[3])
{
    if (!tree || !point || (side != 1 && side != -1) || !isfinite(u) || !isfinite(v)) return MLRT_ERROR_ARGUMENT;
    const uint32_t number = mlrt_triangle_number(tree, mesh, triangle);
    if (number == MLRT_NONE) return MLRT_ERROR_ARGUMENT;
    const uint64_t environment = mlrt_enter_fp_environment();
    const int found = mlrt_find_offset_point(&tree->triangles[number], u, v, side, point);
    mlrt_leave_fp_environment(environment);
    return found ? MLRT_OK : MLRT_ERROR_ARGUMENT;
}
