/* SPDX-License-Identifier: MIT */
/*
 * The scene of scene.h through mlrt.hpp: prints the hash, and checks errors, moves and use after a move.
 */
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <utility>

#include "mlrt.hpp"

#include "../c/scene.h"

static_assert(!std::is_copy_constructible<mlrt::Tree>::value && !std::is_copy_assignable<mlrt::Pool>::value, "");
static_assert(std::is_nothrow_move_constructible<mlrt::Tree>::value, "");

static void require(bool fact, const char *what) {
    if (fact) return;
    std::fprintf(stderr, "failed: %s\n", what);
    std::exit(1);
}

// The status of what `call` throws, whose text must contain `words`.
template <class Call> static int32_t status_of(Call call, const char *words) {
    try {
        call();
    } catch (const mlrt::Error &error) {
        require(std::strstr(error.what(), words) != nullptr, error.what());
        return error.status;
    }
    return MLRT_OK;
}

static uint64_t hash_of(const mlrt::Hits &hits) {
    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    for (size_t i = 0; i < hits.t.size(); i++) {
        hash = hash_hit(hash, hits.t[i], hits.u[i], hits.v[i], hits.mesh[i], hits.triangle[i], hits.facing[i]);
    }
    return hash;
}

int main() {
    static struct scene scene;
    make_scene(&scene);
    std::vector<std::vector<float>> vertices;
    std::vector<std::vector<uint32_t>> indices;
    std::vector<mlrt_mesh> meshes;
    for (int m = 0; m < SCENE_MESHES; m++) {
        vertices.emplace_back(std::begin(scene.vertices[m]), std::end(scene.vertices[m]));
        indices.emplace_back(std::begin(scene.indices[m]), std::end(scene.indices[m]));
    }
    for (int m = 0; m < SCENE_MESHES; m++) meshes.push_back(mlrt::mesh(vertices[m], indices[m], scene_ids[m]));
    const std::vector<float> origins(std::begin(scene.origins), std::end(scene.origins));
    const std::vector<float> directions(std::begin(scene.directions), std::end(scene.directions));

    mlrt::Tree tree(meshes);
    const mlrt::Pool pool(2);
    const mlrt::Hits hits = tree.trace(origins, directions);
    require(hash_of(tree.trace(origins, directions, &pool)) == hash_of(hits), "a pool changes nothing");
    const mlrt::Tree kdtree(meshes, mlrt::make<mlrt_kdtree_options>());
    mlrt_tree_info info = mlrt::make<mlrt_tree_info>();
    require(mlrt_get_tree_info(kdtree.get(), &info) == MLRT_OK && info.structure == MLRT_STRUCTURE_KDTREE, "a kd-tree");
    require(hash_of(kdtree.trace(origins, directions)) == hash_of(hits), "a kd-tree changes nothing");
    const std::vector<uint8_t> occluded = tree.occluded(origins, directions, &pool);
    for (int i = 0; i < SCENE_RAYS; i++)
        require(occluded[i] == (hits.mesh[i] != MLRT_NONE), "any hit is a closest hit");

    indices[1][5] = SCENE_VERTICES;
    require(status_of([&] { mlrt::Tree wrong(meshes); }, "triangle 1") == MLRT_ERROR_INDEX_RANGE, "index out of range");
    require(status_of([&] { mlrt::Pool wrong(5000); }, mlrt_status_string(MLRT_ERROR_ARGUMENT)) == MLRT_ERROR_ARGUMENT,
            "too many threads");
    require(status_of([&] { tree.trace(origins, {}); }, "three floats") == MLRT_ERROR_ARGUMENT,
            "rays without directions");

    mlrt::Tree moved(std::move(tree)), other(meshes = {});
    require(status_of([&] { tree.trace(origins, directions); }, "") == MLRT_ERROR_ARGUMENT, "a moved-from tree");
    other = std::move(moved);
    require(hash_of(other.trace(origins, directions)) == hash_of(hits), "a moved tree");

    std::printf("%016" PRIx64 "\n", hash_of(hits));
    return 0;
}
