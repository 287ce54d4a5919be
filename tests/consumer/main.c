/* SPDX-License-Identifier: MIT */
/*
 * A program outside the tree, in C: the rays of bindings/c/scene.h, traced by two threads. Fails unless the answers
 * have the hash that every binding gets, and header and library are of one version.
 */
#include <inttypes.h>
#include <mlrt.h>
#include <stdio.h>

#include "scene.h"

static struct scene scene;
static float t[SCENE_RAYS], u[SCENE_RAYS], v[SCENE_RAYS];
static uint32_t mesh[SCENE_RAYS], triangle[SCENE_RAYS];
static int32_t facing[SCENE_RAYS];

int main(void)
{
    make_scene(&scene);
    mlrt_mesh meshes[SCENE_MESHES];
    memset(meshes, 0, sizeof meshes);
    for (int m = 0; m < SCENE_MESHES; m++) {
        meshes[m].struct_size = sizeof meshes[m];
        meshes[m].id = scene_ids[m];
        meshes[m].vertices = scene.vertices[m];
        meshes[m].vertex_count = SCENE_VERTICES;
        meshes[m].indices = scene.indices[m];
        meshes[m].triangle_count = SCENE_TRIANGLES;
    }
    mlrt_pool *pool = NULL;
    mlrt_tree *tree = NULL;
    int32_t status = mlrt_create_pool(2, &pool);
    const mlrt_tree_options build = {.struct_size = sizeof build, .pool = pool};
    if (status == MLRT_OK) status = mlrt_build_tree(meshes, SCENE_MESHES, &build, &tree);

    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = SCENE_RAYS,
                            .origins.data = scene.origins,
                            .directions.data = scene.directions};
    const mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool};
    const mlrt_hits hits = {.struct_size = sizeof hits,
                            .t.data = t,
                            .u.data = u,
                            .v.data = v,
                            .mesh.data = mesh,
                            .triangle.data = triangle,
                            .facing.data = facing};
    if (status == MLRT_OK) status = mlrt_trace_packet(tree, &rays, &options, &hits);
    mlrt_destroy_tree(tree);
    mlrt_destroy_pool(pool);

    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    for (int i = 0; i < SCENE_RAYS; i++) hash = hash_hit(hash, t[i], u[i], v[i], mesh[i], triangle[i], facing[i]);
    printf("%s: %016" PRIx64 ", version %u\n", mlrt_status_string(status), hash, (unsigned)mlrt_version());
    return status != MLRT_OK || hash != SCENE_HASH ||
           mlrt_version() != MLRT_VERSION_MAJOR * 10000 + MLRT_VERSION_MINOR * 100 + MLRT_VERSION_PATCH;
}
