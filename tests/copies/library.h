/* SPDX-License-Identifier: MIT */
/*
 * One copy of the library as a table of functions, and a use of it whose answers are a hash: copies that do not disturb
 * each other have the same one.
 */
#ifndef MLRT_TESTS_LIBRARY_H
#define MLRT_TESTS_LIBRARY_H

#include <string.h>

#include "mlrt.h"

struct library {
    int32_t (*build)(const mlrt_mesh *, size_t, const mlrt_tree_options *, mlrt_tree **);
    int32_t (*trace)(const mlrt_tree *, const mlrt_rays *, const mlrt_trace_options *, const mlrt_hits *);
    void (*destroy_tree)(mlrt_tree *);
    int32_t (*create_pool)(uint32_t, mlrt_pool **);
    void (*destroy_pool)(mlrt_pool *);
};

/* What a copy was in the middle of when others had their turn. */
struct use {
    mlrt_pool *pool;
    mlrt_tree *tree;
};

static inline float draw(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (float)(*state >> 40) / 16777216.0f;
}

/* Starts threads and builds a tree of 500 triangles. Returns a status. */
static inline int32_t begin_use(const struct library *library, struct use *use)
{
    float corners[9 * 500];
    uint64_t state = 1;
    for (size_t i = 0; i < sizeof corners / sizeof *corners; i++) {
        // each triangle near its first corner
        float around = i % 9 < 3 ? 0.0f : corners[i - 3 * (i % 9 / 3)] - 0.1f;
        corners[i] = around + draw(&state) * (i % 9 < 3 ? 1.0f : 0.2f);
    }
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 1500, .triangle_count = 500};
    mlrt_tree_options options = {.struct_size = sizeof options};
    memset(use, 0, sizeof *use);
    int32_t status = library->create_pool(2, &use->pool);
    options.pool = use->pool;
    if (status == MLRT_OK) status = library->build(&mesh, 1, &options, &use->tree);
    return status;
}

/* A hash of what 1000 rays hit; 0 = an error. */
static inline uint64_t hash_hits(const struct library *library, const struct use *use)
{
    enum { COUNT = 1000 };
    float origins[3 * COUNT], directions[3 * COUNT], t[COUNT];
    uint32_t triangle[COUNT];
    uint64_t state = 2, hash = 14695981039346656037u;
    for (size_t i = 0; i < 3 * COUNT; i++) {
        origins[i] = i % 3 == 2 ? -1.0f : draw(&state);
        directions[i] = i % 3 == 2 ? 1.0f : 0.5f * draw(&state) - 0.25f;
    }
    mlrt_rays rays = {.struct_size = sizeof rays, .count = COUNT};
    rays.origins.data = origins;
    rays.directions.data = directions;
    mlrt_hits hits = {.struct_size = sizeof hits};
    hits.t.data = t;
    hits.triangle.data = triangle;
    mlrt_trace_options options = {.struct_size = sizeof options, .pool = use->pool};
    if (library->trace(use->tree, &rays, &options, &hits) != MLRT_OK) return 0;
    size_t hit_count = 0;
    for (size_t i = 0; i < COUNT; i++) {
        uint32_t bits;
        memcpy(&bits, &t[i], sizeof bits);
        hash = (hash ^ bits) * 1099511628211u;
        hash = (hash ^ triangle[i]) * 1099511628211u;
        hit_count += triangle[i] != MLRT_NONE;
    }
    return hit_count > COUNT / 4 && hit_count < COUNT ? hash : 0;
}

static inline void end_use(const struct library *library, struct use *use)
{
    library->destroy_tree(use->tree);
    library->destroy_pool(use->pool);
}

#endif
