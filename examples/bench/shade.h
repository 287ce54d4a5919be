/* SPDX-License-Identifier: MIT */
/*
 * shade.h - the simplest shading, the same for all contenders: a grey by the angle between ray and triangle
 *
 * The grey of a hit is 255 |d . n| / |d| with the triangle's unit normal n; the background is a constant. Loops go over
 * the pixels of a row or the lanes of a packet, in short steps on arrays, so that compilers turn them into vectors.
 * Normals come from a table by triangle number. Its last entry is the background's: no direction, but a level of grey.
 */
#ifndef BENCH_SHADE_H
#define BENCH_SHADE_H

#include <mlrt.h>

#include <math.h>

enum { SHADE_LANES = 16, BACKGROUND_LEVEL = 40 };

/* A unit normal, and a level that is added: 0 but for the background. */
struct normal {
    float n[3];
    float level;
};

static inline uint32_t opaque_grey(float level)
{
    return (uint32_t)(int32_t)(level < 255 ? level : 255) * 0x010101u | 0xFF000000u;
}

// The direction is (x, y, z); the normal has length 1, or none and a level.
static inline uint32_t grey_by_angle(float x, float y, float z, const struct normal *normal)
{
    const float product = x * normal->n[0] + y * normal->n[1] + z * normal->n[2];
    return opaque_grey(255 * fabsf(product) / sqrtf(x * x + y * y + z * z) + normal->level);
}

// A quarter of the brightness where `is_dark` is not 0: what a shaded pixel of a lit picture becomes.
static inline uint32_t darken(uint32_t rgba, uint32_t is_dark)
{
    return is_dark ? (rgba >> 2 & 0x3F3F3Fu) | 0xFF000000u : rgba;
}

// Looks up normals by component, and levels. MLRT_NONE, or whatever is not a triangle, is the background.
static inline void gather_normals(const struct normal *normals, uint32_t triangle_count, const uint32_t *triangles,
                                  float n[4][SHADE_LANES])
{
    for (int i = 0; i < SHADE_LANES; i++) {
        const struct normal *normal = &normals[triangles[i] < triangle_count ? triangles[i] : triangle_count];
        n[0][i] = normal->n[0], n[1][i] = normal->n[1], n[2][i] = normal->n[2], n[3][i] = normal->level;
    }
}

/* What a shading callback of the library needs. */
struct shade_job {
    const mlrt_camera *camera;
    const struct normal *normals;
    uint32_t triangle_count;
    uint32_t *rgba; /* camera->width a row */
};

/* Tile callbacks for MLRT_OUTPUT_TRIANGLE, and for MLRT_OUTPUT_OCCLUDED as well; `user` is the struct shade_job. */
int32_t shade_tile_of_ids(void *user, const mlrt_tile *tile);
int32_t shade_lit_tile(void *user, const mlrt_tile *tile);

#endif
