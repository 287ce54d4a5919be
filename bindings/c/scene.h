/* SPDX-License-Identifier: MIT */
/*
 * What every binding's test traces: two meshes, a thousand rays, and the number that the answers must hash to.
 *
 * Anyone can make the same floats in any language: a linear congruential generator of 32 bits gives 12-bit integers,
 * which become coordinates by exact divisions. The numbers are drawn in the order of the code below. Every fourth ray
 * aims at a vertex, which several triangles share: ties, and decisions that only exact arithmetic can make.
 *
 * The hash is FNV-1a of 64 bits (Fowler, Noll, Vo) over six 32-bit words a ray, bytes from the lowest up: the bits of
 * t, u, v, then mesh, triangle, facing.
 */
#ifndef MLRT_BINDINGS_SCENE_H
#define MLRT_BINDINGS_SCENE_H

#include <stdint.h>
#include <string.h>

#define SCENE_HASH UINT64_C(0x78727D0AFAE9AC53)

enum { SCENE_MESHES = 2, SCENE_VERTICES = 100, SCENE_TRIANGLES = 150, SCENE_RAYS = 1000 };

static const uint32_t scene_ids[SCENE_MESHES] = {7, 3};

struct scene {
    float vertices[SCENE_MESHES][3 * SCENE_VERTICES];
    uint32_t indices[SCENE_MESHES][3 * SCENE_TRIANGLES];
    float origins[3 * SCENE_RAYS];
    float directions[3 * SCENE_RAYS];
};

/* 0..4095 */
static uint32_t scene_draw(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 20;
}

/* -2048 / divisor .. 2047 / divisor, exact for powers of two */
static float scene_coordinate(uint32_t *state, float divisor)
{
    return ((float)scene_draw(state) - 2048) / divisor;
}

static void make_scene(struct scene *scene)
{
    uint32_t state = 1;
    for (int m = 0; m < SCENE_MESHES; m++) {
        for (int i = 0; i < 3 * SCENE_VERTICES; i++) scene->vertices[m][i] = scene_coordinate(&state, 256);
        for (int i = 0; i < 3 * SCENE_TRIANGLES; i++) scene->indices[m][i] = scene_draw(&state) % SCENE_VERTICES;
    }
    for (int i = 0; i < SCENE_RAYS; i++) {
        float *origin = &scene->origins[3 * i], *direction = &scene->directions[3 * i];
        const float *vertex = &scene->vertices[0][3 * (i % SCENE_VERTICES)];
        for (int k = 0; k < 3; k++) origin[k] = scene_coordinate(&state, 256);
        for (int k = 0; k < 3; k++) direction[k] = scene_coordinate(&state, 2048);
        for (int k = 0; k < 3 && i % 4 == 3; k++) direction[k] = vertex[k] - origin[k];
    }
}

static uint64_t hash_word(uint64_t hash, uint32_t word)
{
    for (int i = 0; i < 4; i++) hash = (hash ^ (word >> 8 * i & 0xFF)) * UINT64_C(0x100000001B3);
    return hash;
}

static uint64_t hash_float(uint64_t hash, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return hash_word(hash, bits);
}

/* One ray more. The first has the hash UINT64_C(0xCBF29CE484222325). */
static uint64_t hash_hit(uint64_t hash, float t, float u, float v, uint32_t mesh, uint32_t triangle, int32_t facing)
{
    hash = hash_float(hash_float(hash_float(hash, t), u), v);
    return hash_word(hash_word(hash_word(hash, mesh), triangle), (uint32_t)facing);
}

#endif
