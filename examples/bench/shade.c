/* SPDX-License-Identifier: MIT */
/* shade.c - tiles of triangle numbers to grey pixels: see shade.h */
#include "shade.h"

#include <string.h>

enum { STRIP_ROWS = 4 };

// Where the directions of a row are: start + x step, and then `row` is added. Numbers that nothing else can change.
struct row {
    float start[3], step[3], row[3];
    float sample;
};

// One pixel: these are the steps that become vectors.
static inline uint32_t shade_pixel(const struct row *row, float column, const struct normal *normal)
{
    const float x = column + row->sample;
    const float a = (row->start[0] + x * row->step[0]) + row->row[0];
    const float b = (row->start[1] + x * row->step[1]) + row->row[1];
    const float c = (row->start[2] + x * row->step[2]) + row->row[2];
    return grey_by_angle(a, b, c, normal);
}

static int all_equal(const uint32_t *triangles)
{
    uint32_t differences = 0;
    for (int i = 0; i < SHADE_LANES; i++) differences |= triangles[i] ^ triangles[0];
    return differences == 0;
}

static void shade_pixels(const struct shade_job *job, const struct row *some_row, uint32_t x, const uint32_t *triangles,
                         uint32_t *restrict rgba)
{
    const struct row row = *some_row;
    const uint32_t count = job->triangle_count;
    if (all_equal(triangles)) {
        const struct normal normal = job->normals[triangles[0] < count ? triangles[0] : count];
        for (int i = 0; i < SHADE_LANES; i++) rgba[i] = shade_pixel(&row, (float)(int32_t)(x + (uint32_t)i), &normal);
        return;
    }
    float n[4][SHADE_LANES];
    gather_normals(job->normals, count, triangles, n);
    for (int i = 0; i < SHADE_LANES; i++) {
        const struct normal normal = {{n[0][i], n[1][i], n[2][i]}, n[3][i]};
        rgba[i] = shade_pixel(&row, (float)(int32_t)(x + (uint32_t)i), &normal);
    }
}

// The last pixels of a row, when they are fewer than lanes.
static void shade_rest(const struct shade_job *job, const struct row *row, uint32_t x, uint32_t count,
                       const uint32_t *triangles, uint32_t *rgba)
{
    uint32_t some_triangles[SHADE_LANES] = {0}, some_rgba[SHADE_LANES];
    memcpy(some_triangles, triangles, count * sizeof *triangles);
    shade_pixels(job, row, x, some_triangles, some_rgba);
    memcpy(rgba, some_rgba, count * sizeof *rgba);
}

int32_t shade_tile_of_ids(void *user, const mlrt_tile *tile)
{
    const struct shade_job *job = user;
    const mlrt_camera *camera = job->camera;
    struct row row = {.sample = camera->sample_x};
    memcpy(row.start, camera->d00, sizeof row.start);
    memcpy(row.step, camera->dx, sizeof row.step);
    for (uint32_t j = 0; j < tile->height; j++) {
        const float y = (float)(tile->y + j) + camera->sample_y;
        for (int k = 0; k < 3; k++) row.row[k] = y * camera->dy[k];
        const uint32_t *triangles = tile->triangle + (size_t)j * tile->width;
        uint32_t *rgba = job->rgba + (size_t)(tile->y + j) * camera->width + tile->x;
        uint32_t i = 0;
        for (; i + SHADE_LANES <= tile->width; i += SHADE_LANES) {
            shade_pixels(job, &row, tile->x + i, triangles + i, rgba + i);
        }
        if (i < tile->width) shade_rest(job, &row, tile->x + i, tile->width - i, triangles + i, rgba + i);
    }
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
