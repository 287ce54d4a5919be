/* SPDX-License-Identifier: MIT */
/* map.c - what the ray of each pixel costs, in false colours: see map.h */
#include "map.h"

#include "label.h"
#include "must.h"
#include "terminal.h"
#include "timer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const titles[] = {"",           "nodes opened by a ray",   "triangle tests of a ray",
                                     "distance t", "left to double or exact", "nanoseconds for a ray"};

/* ---- values -------------------------------------------------------------------------------------------------- */

static double time_ray(const mlrt_tree *tree, const mlrt_ray *ray, mlrt_hit *hit)
{
    enum { RUNS = 3, CALLS = 4 };
    double least = INFINITY;
    for (int run = 0; run < RUNS; run++) {
        const double start = seconds_now();
        for (int i = 0; i < CALLS; i++) mlrt_trace_ray(tree, ray, NULL, hit);
        least = fmin(least, seconds_now() - start);
    }
    return 1e9 / CALLS * least;
}

static int32_t measure_ray(const mlrt_tree *tree, const mlrt_ray *ray, int32_t map, double *value)
{
    mlrt_counters counters = {.struct_size = sizeof counters};
    mlrt_hit hit = {.struct_size = sizeof hit};
    const int counts = map != MAP_DEPTH && map != MAP_TIME;
    const mlrt_trace_options options = {.struct_size = sizeof options, .counters = counts ? &counters : NULL};
    const int32_t status = mlrt_trace_ray(tree, ray, &options, &hit);
    const uint64_t judged = counters.judged_lane_count + counters.exact_edge_count + counters.exact_range_count +
                            counters.exact_order_count;
    *value = map == MAP_NODES   ? (double)counters.cell_count
             : map == MAP_TESTS ? (double)counters.triangle_test_count
             : map == MAP_JUDGE ? (double)judged
             : map == MAP_DEPTH ? (isfinite(hit.t) ? (double)hit.t : 0)
                                : time_ray(tree, ray, &hit);
    return status;
}

// The values of row y of the picture; `rays` has room for the vectors of a row.
static int32_t measure_row(const mlrt_tree *tree, const mlrt_camera *camera, uint32_t y, int32_t map, float (*rays)[3],
                           double *values)
{
    mlrt_camera row = *camera;
    row.crop_y = y, row.crop_height = 1;
    const mlrt_array origins = {rays, 0, 0}, directions = {rays + camera->width, 0, 0};
    int32_t status = mlrt_camera_rays(&row, &origins, &directions);
    for (uint32_t x = 0; x < camera->width && status == MLRT_OK; x++) {
        mlrt_ray ray = {.struct_size = sizeof ray, .t_min = camera->t_min, .t_max = camera->t_max};
        memcpy(ray.origin, rays[x], sizeof ray.origin);
        memcpy(ray.direction, rays[camera->width + x], sizeof ray.direction);
        status = measure_ray(tree, &ray, map, &values[x]);
    }
    return status;
}

/* ---- colours ------------------------------------------------------------------------------------------------- */

// 0..1, in colours whose brightness grows evenly: six of matplotlib's map "inferno", and what lies between.
static void colour_of(double value, uint8_t rgb[3])
{
    static const double colours[6][3] = {{0, 0, 4},     {66, 10, 104},  {147, 38, 103},
                                         {221, 81, 58}, {252, 165, 10}, {252, 255, 164}};
    const double place = 5 * fmin(fmax(value, 0), 1);
    const int first = place < 5 ? (int)place : 4;
    for (int k = 0; k < 3; k++) {
        rgb[k] = (uint8_t)(colours[first][k] + (place - first) * (colours[first + 1][k] - colours[first][k]) + 0.5);
    }
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// The value of the brightest colour: 99 % of the values are no greater. Sorts a copy of them. 0 = no memory.
static double find_scale(const double *values, size_t count)
{
    double *sorted = malloc(count * sizeof *sorted);
    if (!sorted) return 0;
    memcpy(sorted, values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    double scale = sorted[(count - 1) - (count - 1) / 100];
    if (scale <= 0) scale = sorted[count - 1] > 0 ? sorted[count - 1] : 1;
    free(sorted);
    return scale;
}

// A bar of the colours in the lower left corner, with numbers at its ends, and the title above.
static void draw_legend(const char *title, double scale, uint32_t width, uint32_t height, uint8_t *rgb)
{
    enum { LINE = 2 * LABEL_HEIGHT + 4 };
    const struct canvas canvas = {rgb, width, height};
    const uint32_t bar = width / 3 < 240 ? width / 3 : 240;
    char text[32];
    snprintf(text, sizeof text, "%.3g", scale);
    const uint32_t box = 12 + bar + 2 * LABEL_WIDTH + 2 * LABEL_WIDTH * ((uint32_t)strlen(text) + 1),
                   title_width = 12 + 2 * LABEL_WIDTH * (uint32_t)strlen(title);
    for (uint32_t y = height > 2 * LINE + 4 ? height - 2 * LINE - 4 : 0; y < height; y++) {
        for (uint32_t x = 0; x < width && x < (box > title_width ? box : title_width); x++)
            memset(rgb + 3 * ((size_t)y * width + x), 0, 3);
    }
    draw_label(&canvas, 6, (int)height - 2 * LINE, 2, title);
    draw_label(&canvas, 6, (int)height - LINE, 2, "0");
    for (uint32_t x = 0; x < bar; x++) {
        for (int y = 0; y < 2 * LABEL_HEIGHT && y < (int)height; y++) {
            const size_t pixel = (size_t)(height - LINE + (uint32_t)y) * width + 6 + 2 * LABEL_WIDTH + x;
            if (height >= LINE && 6 + 2 * LABEL_WIDTH + x < width) colour_of((double)x / bar, rgb + 3 * pixel);
        }
    }
    draw_label(&canvas, (int)(6 + 3 * LABEL_WIDTH + bar), (int)height - LINE, 2, text);
}

static int draw_values(const double *values, const char *title, const mlrt_camera *camera, uint8_t *rgb)
{
    const size_t count = (size_t)camera->width * camera->height;
    const double scale = find_scale(values, count);
    if (scale == 0) {
        fprintf(stderr, "not enough memory for a map of %zu pixels\n", count);
        return 1;
    }
    for (size_t i = 0; i < count; i++) colour_of(values[i] / scale, rgb + 3 * i);
    draw_legend(title, scale, camera->width, camera->height, rgb);
    return 0;
}

/* ---- map ----------------------------------------------------------------------------------------------------- */

int draw_map(const mlrt_tree *tree, const mlrt_camera *camera, int32_t map, uint8_t *rgb)
{
    const size_t count = (size_t)camera->width * camera->height;
    double *values = malloc(count * sizeof *values);
    float(*rays)[3] = malloc(2 * (size_t)camera->width * sizeof *rays);
    struct progress_line line = {.work = "measuring rays"};
    const mlrt_host host = host_with_progress(&line);
    int failed = !values || !rays;
    if (failed) fprintf(stderr, "not enough memory for a map of %zu pixels\n", count);
    for (uint32_t y = 0; y < camera->height && !failed; y++) {
        const int32_t status = measure_row(tree, camera, y, map, rays, values + (size_t)y * camera->width);
        host.progress(host.user, (y + 1.0) / camera->height);
        if (status != MLRT_OK) clear_progress(&line);
        failed = has_failed(status, "draw the map");
    }
    clear_progress(&line);
    if (!failed) failed = draw_values(values, titles[map], camera, rgb);
    free(values);
    free(rays);
    return failed;
}
