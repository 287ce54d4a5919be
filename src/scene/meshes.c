/* SPDX-License-Identifier: MIT */
/* The caller's meshes: see meshes.h. */
#include "scene/meshes.h"

#include <string.h>

#include "base/platform.h"
#include "base/progress.h"
#include "base/scheduler.h"
#include "base/structs.h"
#include "scene/triangle_numbers.h"

/* Triangles that a worker copies at a time, before it calls mlrt_advance: less than a millisecond. */
#define CHUNK_SIZE 8192

#define PATH "meshes[%lu]"

/* ---- one mesh ---- */

MLRT_NOINLINE mlrt_mesh mlrt_mesh_at(const mlrt_mesh *meshes, size_t i)
{
    mlrt_mesh mesh;
    (void)mlrt_take_struct(MLRT_STRUCT_MESH, PATH, i, meshes, &mesh);
    if (mesh.index_size == 0) mesh.index_size = 4;
    if (mesh.vertex_stride == 0) mesh.vertex_stride = 12;
    if (mesh.triangle_stride == 0) mesh.triangle_stride = 3 * (size_t)mesh.index_size;
    if (mesh.mask == 0) mesh.mask = MLRT_MASK_ALL;
    return mesh;
}

static int32_t check_mesh(const mlrt_mesh *meshes, size_t i)
{
    mlrt_mesh given;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_MESH, PATH, i, meshes, &given);
    if (status != MLRT_OK) return status;
    const mlrt_mesh mesh = mlrt_mesh_at(meshes, i);
    if (mesh.index_size != 2 && mesh.index_size != 4) {
        return mlrt_fail(MLRT_ERROR_ARGUMENT, PATH ".index_size: %lu is not 2 or 4", (unsigned long)i,
                         (unsigned long)mesh.index_size);
    }
    if (mesh.triangle_count == 0 || mesh.triangle_count > MLRT_TRIANGLE_LIMIT) return MLRT_OK;
    if (!mesh.vertices && mesh.vertex_count)
        return mlrt_fail_at(MLRT_ERROR_ARGUMENT, PATH, i, "vertices", "NULL, but vertex_count is not 0");
    status = mlrt_check_array(PATH, i, "vertices", mesh.vertices, mesh.vertex_stride, 4, 12);
    if (status != MLRT_OK) return status;
    return mlrt_check_array(PATH, i, "indices", mesh.indices, mesh.triangle_stride, mesh.index_size,
                            3 * (size_t)mesh.index_size);
}

int32_t mlrt_check_meshes(const mlrt_mesh *meshes, size_t mesh_count, uint32_t *triangle_count)
{
    uint64_t sum = 0;
    char digits[MLRT_DIGITS];
    *triangle_count = 0;
    if (!meshes && mesh_count) return mlrt_fail(MLRT_ERROR_ARGUMENT, "meshes: NULL, but mesh_count is not 0");
    if (mesh_count > INT32_MAX) {
        return mlrt_fail(MLRT_ERROR_TOO_LARGE, "mesh_count: %s is more than 2147483647",
                         mlrt_write_digits(mesh_count, digits));
    }
    for (size_t i = 0; i < mesh_count; ++i) {
        const int32_t status = check_mesh(meshes, i);
        if (status != MLRT_OK) return status;
        const uint64_t count = mlrt_mesh_at(meshes, i).triangle_count;
        sum = count <= UINT64_MAX - sum ? sum + count : UINT64_MAX;
        if (sum > MLRT_TRIANGLE_LIMIT) {
            return mlrt_fail(MLRT_ERROR_TOO_LARGE, PATH ".triangle_count: %s triangles up to here are more than %lu",
                             (unsigned long)i, mlrt_write_digits(sum, digits), (unsigned long)MLRT_TRIANGLE_LIMIT);
        }
    }
    *triangle_count = (uint32_t)sum;
    return MLRT_OK;
}

/* The index of vertex `corner` of a triangle. */
static uint64_t vertex_index(const mlrt_mesh *mesh, size_t triangle, int corner)
{
    if (!mesh->indices) return (uint64_t)triangle * 3 + (uint64_t)corner;
    const unsigned char *triple = (const unsigned char *)mesh->indices + triangle * mesh->triangle_stride;
    if (mesh->index_size == 2) return ((const uint16_t *)(const void *)triple)[corner];
    return ((const uint32_t *)(const void *)triple)[corner];
}

int32_t mlrt_copy_triangle(const mlrt_mesh *mesh, size_t i, size_t triangle, int is_told, struct mlrt_triangle *copy)
{
    for (int corner = 0; corner < 3; ++corner) {
        const uint64_t index = vertex_index(mesh, triangle, corner);
        if (index < mesh->vertex_count) {
            memcpy(copy->v[corner], (const unsigned char *)mesh->vertices + (size_t)index * mesh->vertex_stride, 12);
            continue;
        }
        if (!is_told) return MLRT_ERROR_INDEX_RANGE;
        return mlrt_fail(
            MLRT_ERROR_INDEX_RANGE, PATH ", triangle %lu: vertex index %lu is out of range (vertex_count is %lu)",
            (unsigned long)i, (unsigned long)triangle, (unsigned long)index, (unsigned long)mesh->vertex_count);
    }
    return MLRT_OK;
}

/* ---- ids ---- */

/*
 * Moves position i of `count` down to its place in a heap of positions with the greatest id on top. No qsort: it may
 * take memory that is not the host's.
 */
static void sift_down(const uint32_t *ids, uint32_t *heap, uint32_t i, uint32_t count)
{
    const uint32_t sifted = heap[i];
    for (uint32_t child; (child = 2 * i + 1) < count; i = child) {
        if (child + 1 < count && ids[heap[child + 1]] > ids[heap[child]]) ++child;
        if (ids[heap[child]] <= ids[sifted]) break;
        heap[i] = heap[child];
    }
    heap[i] = sifted;
}

/* Sorts positions by id, which makes equal ids neighbours. Ids must be distinct and not MLRT_NONE. Returns a status. */
static int32_t sort_mesh_ids(struct mlrt_tree *tree)
{
    const uint32_t *ids = tree->meshes.ids, count = tree->meshes.count;
    uint32_t *sorted = tree->meshes.by_id;
    for (uint32_t i = 0; i < count; ++i) sorted[i] = i;
    for (uint32_t i = count / 2; i-- > 0;) sift_down(ids, sorted, i, count);
    for (uint32_t left = count; left > 1;) {
        const uint32_t greatest = sorted[0];
        sorted[0] = sorted[--left];
        sorted[left] = greatest;
        sift_down(ids, sorted, 0, left);
    }
    for (uint32_t i = 0; i < count; ++i) {
        const unsigned long id = ids[sorted[i]], position = sorted[i], last = i > 0 ? sorted[i - 1] : position;
        if (id == MLRT_NONE) return mlrt_fail(MLRT_ERROR_ARGUMENT, PATH ".id: MLRT_NONE stands for no mesh", position);
        if (position != last && id == ids[last]) {
            return mlrt_fail(MLRT_ERROR_ARGUMENT, PATH ".id: %lu is the id of meshes[%lu] too",
                             position > last ? position : last, id, position > last ? last : position);
        }
    }
    return MLRT_OK;
}

/* Sets the ids as given, or to positions if all are 0. Returns a status. */
static int32_t set_mesh_ids(const mlrt_mesh *meshes, struct mlrt_tree *tree)
{
    uint32_t any = 0;
    for (uint32_t i = 0; i < tree->meshes.count; ++i) any |= tree->meshes.ids[i] = mlrt_mesh_at(meshes, i).id;
    for (uint32_t i = 0; i < tree->meshes.count && !any; ++i) tree->meshes.ids[i] = i;
    return sort_mesh_ids(tree);
}

/* ---- triangles and masks ---- */

/* A call that copies, for the workers of a pool. */
struct copying {
    const mlrt_mesh *meshes;
    struct mlrt_progress *progress;
    struct mlrt_tree *tree;
    int is_told; /* errors get a message: chunks are copied by the thread of the call */
};

static int32_t copy_chunk(void *work, uint32_t item, uint32_t worker)
{
    const struct copying *copying = work;
    struct mlrt_tree *tree = copying->tree;
    uint32_t number = item * CHUNK_SIZE;
    const uint32_t count = mlrt_item_size(tree->triangle_count, CHUNK_SIZE, item), end = number + count;
    (void)worker;
    for (uint32_t position = mlrt_mesh_of_triangle(tree, number); number < end; ++position) {
        const mlrt_mesh mesh = mlrt_mesh_at(copying->meshes, position);
        for (; number < end && number < tree->meshes.first[position + 1]; ++number) {
            const int32_t status = mlrt_copy_triangle(&mesh, position, number - tree->meshes.first[position],
                                                      copying->is_told, &tree->triangles[number]);
            if (status != MLRT_OK) return status;
        }
    }
    return mlrt_advance(copying->progress, count * MLRT_COPY_WORK) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

/*
 * After an error of a worker, the chunks are copied once more in order, by the thread of the call: the message is its
 * own then, and always the same one.
 */
static int32_t copy_triangles(struct copying *copying, mlrt_pool *pool)
{
    const uint32_t chunk_count = mlrt_item_count(copying->tree->triangle_count, CHUNK_SIZE);
    const int32_t status = mlrt_run_items(pool, chunk_count, copy_chunk, copying);
    copying->is_told = 1;
    return status == MLRT_ERROR_INDEX_RANGE ? mlrt_run_items(NULL, chunk_count, copy_chunk, copying) : status;
}

int mlrt_have_masks(const mlrt_mesh *meshes, size_t mesh_count)
{
    uint32_t common = MLRT_MASK_ALL;
    for (size_t i = 0; i < mesh_count; ++i) common &= mlrt_mesh_at(meshes, i).mask;
    return common != MLRT_MASK_ALL;
}

/* Sets the mask of each triangle, if a mesh has a mask. Returns a status. */
static int32_t set_masks(const mlrt_mesh *meshes, struct mlrt_tree *tree)
{
    if (!mlrt_have_masks(meshes, tree->meshes.count)) return MLRT_OK;
    tree->masks = mlrt_allocate(&tree->memory, tree->triangle_count, sizeof *tree->masks);
    if (!tree->masks) return MLRT_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; i < tree->meshes.count; ++i) {
        const uint32_t mask = mlrt_mesh_at(meshes, i).mask;
        for (uint32_t j = tree->meshes.first[i]; j < tree->meshes.first[i + 1]; ++j) tree->masks[j] = mask;
    }
    return MLRT_OK;
}

static int allocate_tables(struct mlrt_tree *tree)
{
    tree->meshes.ids = mlrt_allocate(&tree->memory, tree->meshes.count, sizeof *tree->meshes.ids);
    tree->meshes.by_id = mlrt_allocate(&tree->memory, tree->meshes.count, sizeof *tree->meshes.by_id);
    tree->meshes.first = mlrt_allocate(&tree->memory, (size_t)tree->meshes.count + 1, sizeof *tree->meshes.first);
    tree->triangles = mlrt_allocate(&tree->memory, tree->triangle_count, sizeof *tree->triangles);
    mlrt_find_triangles(tree);
    return tree->meshes.ids && tree->meshes.by_id && tree->meshes.first && tree->triangles;
}

int32_t mlrt_copy_meshes(const mlrt_mesh *meshes, size_t mesh_count, mlrt_pool *pool, struct mlrt_progress *progress,
                         struct mlrt_tree *tree)
{
    struct copying copying = {meshes, progress, tree, 0};
    tree->meshes.count = (uint32_t)mesh_count;
    if (!allocate_tables(tree)) return MLRT_ERROR_OUT_OF_MEMORY;
    int32_t status = set_mesh_ids(meshes, tree);
    tree->meshes.first[0] = 0;
    for (uint32_t i = 0; i < tree->meshes.count; ++i)
        tree->meshes.first[i + 1] = tree->meshes.first[i] + (uint32_t)mlrt_mesh_at(meshes, i).triangle_count;
    if (status == MLRT_OK) status = copy_triangles(&copying, pool);
    return status == MLRT_OK ? set_masks(meshes, tree) : status;
}

void mlrt_free_meshes(struct mlrt_tree *tree)
{
    mlrt_free(&tree->memory, tree->triangles, tree->triangle_count, sizeof *tree->triangles);
    mlrt_free(&tree->memory, tree->masks, tree->triangle_count, sizeof *tree->masks);
    mlrt_free(&tree->memory, tree->meshes.ids, tree->meshes.count, sizeof *tree->meshes.ids);
    mlrt_free(&tree->memory, tree->meshes.by_id, tree->meshes.count, sizeof *tree->meshes.by_id);
    mlrt_free(&tree->memory, tree->meshes.first, (size_t)tree->meshes.count + 1, sizeof *tree->meshes.first);
}
