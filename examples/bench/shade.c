/* SPDX-License-Identifier: MIT */
/* shade.c - tiles of triangle numbers to grey pixels: see shade.h */
#include "shade.h"

#include <string.h>

// Pixels of a row share y: base is fl(y dy).
struct row {
    const mlrt_camera *camera;
    float base[3];
};

static void make_directions(const struct row *row, uint32_t x, struct lanes *lanes)
{
    const mlrt_camera *camera = row->camera;
    float column[SHADE_LANES];
    for (int i = 0; i < SHADE_LANES; i++) column[i] = (float)(int32_t)(x + (uint32_t)i) + camera->sample_x;
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < SHADE_LANES; i++) {
            lanes->d[k][i] = (camera->d00[k] + column[i] * camera->dx[k]) + row->base[k];
        }
    }
}

static int all_equal(const uint32_t *triangles)
{
    uint32_t differences = 0;
    for (int i = 0; i < SHADE_LANES; i++) differences |= triangles[i] ^ triangles[0];
    return differences == 0;
}

static void spread_normal(const struct normal *normal, struct lanes *lanes)
{
    for (int i = 0; i < SHADE_LANES; i++) {
        lanes->n[0][i] = normal->n[0], lanes->n[1][i] = normal->n[1], lanes->n[2][i] = normal->n[2];
        lanes->level[i] = normal->level;
    }
}

static void shade_pixels(const struct shade_job *job, const struct row *row, uint32_t x, const uint32_t *triangles,
                         uint32_t *rgba)
{
    struct lanes lanes;
    make_directions(row, x, &lanes);
    if (all_equal(triangles)) {
        spread_normal(&job->normals[triangles[0] < job->triangle_count ? triangles[0] : job->triangle_count], &lanes);
    } else {
        gather_normals(job->normals, job->triangle_count, triangles, SHADE_LANES, &lanes);
    }
    shade_lanes(&lanes, SHADE_LANES, rgba);
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
    struct row row = {.camera = job->camera};
    for (uint32_t j = 0; j < tile->height; j++) {
        const float y = (float)(tile->y + j) + job->camera->sample_y;
        for (int k = 0; k < 3; k++) row.base[k] = y * job->camera->dy[k];
        const uint32_t *triangles = tile->triangle + (size_t)j * tile->width;
        uint32_t *rgba = job->rgba + (size_t)(tile->y + j) * job->camera->width + tile->x;
        uint32_t i = 0;
        for (; i + SHADE_LANES <= tile->width; i += SHADE_LANES) {
            shade_pixels(job, &row, tile->x + i, triangles + i, rgba + i);
        }
        if (i < tile->width) shade_rest(job, &row, tile->x + i, tile->width - i, triangles + i, rgba + i);
    }
    return 0;
}
