/* SPDX-License-Identifier: MIT */
/*
 * Traces the rays of scene.h through the C ABI itself and prints their hash, which is what the other languages' tests
 * must print. Ends with 1 if it is not SCENE_HASH, which tests/test_bindings.c has from the exact reference.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include <mlrt.h>

#include "scene.h"

static struct scene scene;
static float t[SCENE_RAYS], u[SCENE_RAYS], v[SCENE_RAYS];
static uint32_t mesh[SCENE_RAYS], triangle[SCENE_RAYS];
static int32_t facing[SCENE_RAYS];

static void check(int32_t status)
{
    if (status == MLRT_OK) return;
    fprintf(stderr, "%s\n", mlrt_status_string(status));
    exit(1);
}

static mlrt_tree *build(void)
{
    mlrt_tree *tree;
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
    check(mlrt_build_tree(meshes, SCENE_MESHES, NULL, &tree));
    return tree;
}

int main(void)
{
    make_scene(&scene);
    mlrt_tree *tree = build();
    mlrt_rays rays = {.struct_size = sizeof rays, .count = SCENE_RAYS};
    rays.origins.data = scene.origins;
    rays.directions.data = scene.directions;
    mlrt_hits hits = {.struct_size = sizeof hits};
    hits.t.data = t;
    hits.u.data = u;
    hits.v.data = v;
    hits.mesh.data = mesh;
    hits.triangle.data = triangle;
    hits.facing.data = facing;
    check(mlrt_trace_packet(tree, &rays, NULL, &hits));
    mlrt_destroy_tree(tree);

    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    for (int i = 0; i < SCENE_RAYS; i++) hash = hash_hit(hash, t[i], u[i], v[i], mesh[i], triangle[i], facing[i]);
    printf("%016" PRIx64 "\n", hash);
    return hash != SCENE_HASH;
}
