/* SPDX-License-Identifier: MIT */
/* A program outside the tree, in C++ with mlrt.hpp: as main.c. */
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <mlrt.hpp>

#include "scene.h"

static struct scene scene;

int main()
{
    make_scene(&scene);
    std::vector<std::vector<float>> vertices;
    std::vector<std::vector<uint32_t>> indices;
    for (int m = 0; m < SCENE_MESHES; m++) {
        vertices.emplace_back(std::begin(scene.vertices[m]), std::end(scene.vertices[m]));
        indices.emplace_back(std::begin(scene.indices[m]), std::end(scene.indices[m]));
    }
    std::vector<mlrt_mesh> meshes;
    for (int m = 0; m < SCENE_MESHES; m++) meshes.push_back(mlrt::mesh(vertices[m], indices[m], scene_ids[m]));
    const mlrt::Tree tree(meshes);
    const mlrt::Pool pool(2);
    const mlrt::Hits hits =
        tree.trace(std::vector<float>(std::begin(scene.origins), std::end(scene.origins)),
                   std::vector<float>(std::begin(scene.directions), std::end(scene.directions)), &pool);

    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    for (int i = 0; i < SCENE_RAYS; i++)
        hash = hash_hit(hash, hits.t[i], hits.u[i], hits.v[i], hits.mesh[i], hits.triangle[i], hits.facing[i]);
    std::printf("%016llx\n", (unsigned long long)hash);
    return hash != SCENE_HASH;
}
