/* SPDX-License-Identifier: MIT */
/* shade.c - tiles of triangle numbers to grey pixels: see shade.h */
#include "shade.h"

#include <string.h>

enum { STRIP_ROWS = 4 };

// The part of the directions that is the same in all rows, for some columns side by side.
struct columns {
    float x[SHADE_LANES], y[SHADE_LANES], z[SHADE_LANES];
};

static void find_columns(const mlrt_camera *camera, uint32_t first, struct columns *restrict columns)
{
    const float start[3] = {camera->d00[0], camera->d00[1], camera->d00[2]};
    const float step[3] = {camera->dx[0], camera->dx[1], camera->dx[2]}, sample = camera->sample_x;
    for (int i = 0; i < SHADE_LANES; i++) {
        const float column = (float)((int32_t)first + i) + sample;
        columns->x[i] = start[0] + column * step[0];
        columns->y[i] = start[1] + column * step[1];
        columns->z[i] = start[2] + column * step[2];
    }
}

// One pixel: these are the steps that become vectors. `row`: the part of the direction that all columns share.
static inline uint32_t shade_pixel(const struct columns *columns, int i, const float row[3],
                                   const struct normal *normal)
{
    return grey_by_angle(columns->x[i] + row[0], columns->y[i] + row[1], columns->z[i] + row[2], normal);
}

// Two at a time.
static int all_equal(const uint32_t triangles[SHADE_LANES])
{
    uint64_t pairs[SHADE_LANES / 2];
    memcpy(pairs, triangles, sizeof pairs);
    uint64_t differences = (uint32_t)pairs[0] ^ pairs[0] >> 32;
    for (int i = 1; i < SHADE_LANES / 2; i++) differences |= pairs[i] ^ pairs[0];
    return differences == 0;
}

static void shade_mixed(const struct shade_job *job, const struct columns *restrict columns, const float some_row[3],
                        const uint32_t *restrict triangles, uint32_t *restrict rgba)
{
    const float row[3] = {some_row[0], some_row[1], some_row[2]};
    float n[4][SHADE_LANES];
    gather_normals(job->normals, job->triangle_count, triangles, n);
    for (int i = 0; i < SHADE_LANES; i++) {
        const struct normal normal = {{n[0][i], n[1][i], n[2][i]}, n[3][i]};
        rgba[i] = shade_pixel(columns, i, row, &normal);
    }
}

static inline void shade_pixels(const struct shade_job *job, const struct columns *restrict columns, const float row[3],
                                const uint32_t *triangles, uint32_t *restrict rgba)
{
    if (!all_equal(triangles)) {
        shade_mixed(job, columns, row, triangles, rgba);
        return;
    }
    const uint32_t count = job->triangle_count;
    const struct normal normal = job->normals[triangles[0] < count ? triangles[0] : count];
    for (int i = 0; i < SHADE_LANES; i++) rgba[i] = shade_pixel(columns, i, row, &normal);
}

// The last pixels of a row, when they are fewer than lanes.
static void shade_rest(const struct shade_job *job, const struct columns *columns, const float row[3], uint32_t count,
                       const uint32_t *triangles, uint32_t *rgba)
{
    uint32_t some_triangles[SHADE_LANES] = {0}, some_rgba[SHADE_LANES];
    memcpy(some_triangles, triangles, count * sizeof *triangles);
    shade_pixels(job, columns, row, some_triangles, some_rgba);
    memcpy(rgba, some_rgba, count * sizeof *rgba);
}

// The columns of a tile from `first` on, as many as there are lanes.
static void shade_strip(const struct shade_job *job, const mlrt_tile *tile, uint32_t first)
{
    const mlrt_camera *camera = job->camera;
    struct columns columns;
    find_columns(camera, tile->x + first, &columns);
    const uint32_t count = tile->width - first;
    const uint32_t *triangles = tile->triangle + first;
    uint32_t *rgba = job->rgba + (size_t)tile->y * camera->width + tile->x + first;
    for (uint32_t j = 0; j < tile->height; j++, triangles += tile->width, rgba += camera->width) {
        const float y = (float)(tile->y + j) + camera->sample_y;
        const float row[3] = {y * camera->dy[0], y * camera->dy[1], y * camera->dy[2]};
        if (count >= SHADE_LANES) {
            shade_pixels(job, &columns, row, triangles, rgba);
        } else {
            shade_rest(job, &columns, row, count, triangles, rgba);
        }
    }
}

int32_t shade_tile_of_ids(void *user, const mlrt_tile *tile)
{
    for (uint32_t i = 0; i < tile->width; i += SHADE_LANES) shade_strip(user, tile, i);
    return 0;
}

static void darken_pixels(const uint8_t *restrict occluded, uint32_t count, uint32_t *restrict rgba)
{
    for (uint32_t i = 0; i < count; i++) rgba[i] = darken(rgba[i], occluded[i]);
}

// A few rows at a time: a tile's rows in the picture can be so far apart that they do not stay in the cache.
int32_t shade_lit_tile(void *user, const mlrt_tile *tile)
{
    const struct shade_job *job = user;
    mlrt_tile part = *tile;
    for (uint32_t j = 0; j < tile->height; j += part.height) {
        part.y = tile->y + j;
        part.height = tile->height - j < STRIP_ROWS ? tile->height - j : STRIP_ROWS;
        part.triangle = tile->triangle + (size_t)j * tile->width;
        shade_tile_of_ids(user, &part);
        for (uint32_t k = 0; k < part.height; k++) {
            darken_pixels(tile->occluded + (size_t)(j + k) * tile->width, tile->width,
                          job->rgba + (size_t)(part.y + k) * job->camera->width + tile->x);
        }
    }
    return 0;
}
