/* SPDX-License-Identifier: MIT */
/*
 * occlusion.c - ambient occlusion: the share of rays from each point that a picture shows which hit nothing near it
 *
 *     occlusion --scene office -o office.pgm
 *
 * From each hit of the picture's rays start `--samples` rays, cosine-weighted around the normal, as long as `--reach`
 * percent of the scene's diagonal. With rays_per_origin the array of origins has one element for each point, and with
 * MLRT_STRIDE_ALL one t_max serves all rays: no number is stored twice.
 *
 * Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#include "common/file.h"
#include "common/interior.h"
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

struct settings {
    const char *scene, *view, *output;
    uint32_t size, samples, reach, threads;
};

/* ---- what the picture shows ---------------------------------------------------------------------------------- */

/* The points that are seen: an element each, in the order of the pixels. */
struct points {
    size_t count;
    uint32_t *pixels;
    float (*positions)[3]; // just off the surface, on the side of the eye
    float (*normals)[3];   // of that side, of length 1
    uint32_t (*skip)[2];   // the triangle that the point lies on
};

/* The normal of a triangle on the side that a ray came from. */
static void find_normal(const struct scene *scene, uint32_t triangle, int32_t facing, float normal[3])
{
    double side[2][3], n[3];
    const uint32_t *corners = scene->indices + 3 * (size_t)triangle;
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 3; k++) {
            side[i][k] = (double)scene->vertices[3 * corners[i + 1] + k] - (double)scene->vertices[3 * corners[0] + k];
        }
    }
    for (int k = 0; k < 3; k++) {
        n[k] = side[0][(k + 1) % 3] * side[1][(k + 2) % 3] - side[0][(k + 2) % 3] * side[1][(k + 1) % 3];
    }
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++) normal[k] = (float)(-facing * n[k] / length);
}

static struct points find_points(const mlrt_tree *tree, const struct scene *scene, const mlrt_camera *camera,
                                 mlrt_pool *pool)
{
    const size_t pixel_count = (size_t)camera->width * camera->height;
    struct points points = {.pixels = must_allocate(pixel_count, sizeof *points.pixels),
                            .positions = must_allocate(pixel_count, sizeof *points.positions),
                            .normals = must_allocate(pixel_count, sizeof *points.normals),
                            .skip = must_allocate(pixel_count, sizeof *points.skip)};
    float *u = must_allocate(pixel_count, sizeof *u), *v = must_allocate(pixel_count, sizeof *v);
    uint32_t *triangles = must_allocate(pixel_count, sizeof *triangles);
    int32_t *facing = must_allocate(pixel_count, sizeof *facing);
    const mlrt_trace_options options = {.struct_size = sizeof options, .pool = pool};
    const mlrt_hits frame = {.struct_size = sizeof frame,
                             .u = {u, 0, 0},
                             .v = {v, 0, 0},
                             .triangle = {triangles, 0, 0},
                             .facing = {facing, 0, 0}};
    must_succeed(mlrt_render_tiles(tree, camera, &options, &frame, NULL, NULL));
    for (size_t i = 0; i < pixel_count; i++) {
        const size_t n = points.count;
        if (triangles[i] == MLRT_NONE) continue;
        if (mlrt_offset_point(tree, 0, triangles[i], u[i], v[i], -facing[i], points.positions[n]) != MLRT_OK) continue;
        find_normal(scene, triangles[i], facing[i], points.normals[n]);
        points.skip[n][0] = 0;
        points.skip[n][1] = triangles[i];
        points.pixels[n] = (uint32_t)i;
        points.count++;
    }
    free(u);
    free(v);
    free(triangles);
    free(facing);
    return points;
}

static void free_points(struct points *points)
{
    free(points->pixels);
    free(points->positions);
    free(points->normals);
    free(points->skip);
}

/* ---- what the points see ------------------------------------------------------------------------------------- */

/*
 * Directions around a normal, of length 1, cosine-weighted: the normal plus a point of the unit sphere. These points
 * lie on a spiral, evenly, and `turn` turns it, so that neighbours do not have the same error.
 */
static void sample_hemisphere(const float normal[3], uint32_t sample_count, float turn, float (*directions)[3])
{
    for (uint32_t s = 0; s < sample_count; s++) {
        const float z = 1 - (2 * (float)s + 1) / (float)sample_count, r = sqrtf(1 - z * z),
                    angle = 2.3999632f * (float)s + turn;
        const float sphere[3] = {r * cosf(angle), r * sinf(angle), z};
        float length = 0;
        for (int k = 0; k < 3; k++) {
            directions[s][k] = normal[k] + sphere[k];
            length += directions[s][k] * directions[s][k];
        }
        length = sqrtf(length);
        for (int k = 0; k < 3; k++) directions[s][k] = length > 1e-3f ? directions[s][k] / length : normal[k];
    }
}

/* Which rays of the points hit something within `reach`: `samples` of each point, side by side. */
static void trace_samples(const mlrt_tree *tree, const struct points *points, uint32_t samples, float (*directions)[3],
                          float reach, mlrt_pool *pool, uint8_t *occluded)
{
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = points->count * samples,
                            .rays_per_origin = samples,
                            .origins = {points->positions, 0}, // and skip: one for each point
                            .skip = {points->skip, 0},
                            .directions = {directions, 0},
                            .t_max = {&reach, MLRT_STRIDE_ALL}}; // one for all
    const mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY, .pool = pool};
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
    must_succeed(mlrt_trace_packet(tree, &rays, &options, &hits));
}

/* Bytes of grey: 255 where every ray is free. */
static void draw(const struct points *points, uint32_t samples, const uint8_t *occluded, uint8_t *grey)
{
    for (size_t i = 0; i < points->count; i++) {
        uint32_t free_count = 0;
        for (uint32_t s = 0; s < samples; s++) free_count += !occluded[i * samples + s];
        grey[points->pixels[i]] = (uint8_t)(255 * free_count / samples);
    }
}

static double diagonal(const struct scene *scene)
{
    float lo[3], hi[3];
    double square = 0; // of a float it could leave the range
    scene_bounds(scene, lo, hi);
    for (int k = 0; k < 3; k++) square += ((double)hi[k] - (double)lo[k]) * ((double)hi[k] - (double)lo[k]);
    return sqrt(square);
}

/* ---- the program --------------------------------------------------------------------------------------------- */

static int write_picture(const char *path, const uint8_t *grey, uint32_t width, uint32_t height)
{
    struct output_file output;
    const size_t count = (size_t)width * height;
    if (open_output(path, &output)) return 1;
    int failed = fprintf(output.file, "P5\n%u %u\n255\n", (unsigned)width, (unsigned)height) < 0;
    failed |= fwrite(grey, 1, count, output.file) != count;
    if (failed) fprintf(stderr, "%s: cannot be written: %s\n", path, strerror(errno));
    return close_output(&output, failed);
}

static int draw_scene(const struct settings *settings, const struct scene *scene, const mlrt_tree *tree,
                      mlrt_pool *pool)
{
    mlrt_camera camera;
    if (camera_of_view(&scene->view, settings->size, settings->size, &camera)) return 1;
    const size_t pixel_count = (size_t)camera.width * camera.height;
    struct points points = find_points(tree, scene, &camera, pool);
    const size_t ray_count = points.count * settings->samples;
    float(*directions)[3] = must_allocate(ray_count, sizeof *directions);
    uint8_t *occluded = must_allocate(ray_count, 1), *grey = must_allocate(pixel_count, 1);
    for (size_t i = 0; i < points.count; i++) {
        const uint32_t mixed = points.pixels[i] * 2654435761u; // neighbours differ in its upper bits
        sample_hemisphere(points.normals[i], settings->samples, 6.2831853f / 4294967296.0f * (float)mixed,
                          directions + i * settings->samples);
    }
    const double start = seconds_now();
    trace_samples(tree, &points, settings->samples, directions, (float)(diagonal(scene) * settings->reach / 100), pool,
                  occluded);
    const double seconds = seconds_now() - start;
    size_t free_count = 0;
    for (size_t i = 0; i < ray_count; i++) free_count += !occluded[i];
    memset(grey, 0, pixel_count);
    draw(&points, settings->samples, occluded, grey);
    printf("points %zu\nrays %zu\nfree_share %.6f\nseconds %.4f\nMray/s %.1f\n", points.count, ray_count,
           ray_count ? (double)free_count / (double)ray_count : 0.0, seconds, (double)ray_count / seconds * 1e-6);
    const int failed = settings->output && write_picture(settings->output, grey, camera.width, camera.height);
    free_points(&points);
    free(directions);
    free(occluded);
    free(grey);
    return failed;
}

int main(int argc, char **argv)
{
    struct settings settings = {.scene = "room", .size = 512, .samples = 16, .reach = 10, .threads = 1};
    const struct option options[] = {
        {OPTION_TEXT, "--scene", &settings.scene, "NAME|FILE", "the scene (default: room)", 0, 0},
        {OPTION_TEXT, "--view", &settings.view, "FILE.json:SCENE", "from where to look at it", 0, 0},
        {OPTION_COUNT, "--size", &settings.size, "N", "pixels per side (default: 512)", 1, 4096},
        {OPTION_COUNT, "--samples", &settings.samples, "N", "rays from each point (default: 16)", 1, 64},
        {OPTION_COUNT, "--reach", &settings.reach, "N", "percent of the scene's diagonal (default: 10)", 1, 100},
        {OPTION_COUNT, "--threads", &settings.threads, "N", "threads (default: 1)", 1, 1024},
        {OPTION_TEXT, "-o", &settings.output, "FILE.pgm", "where to write the picture", 0, 0},
    };
    int exit_code;
    if (!parse_options("occlusion - how much of the sky each point of a picture sees", options, LENGTH(options), argc,
                       argv, &exit_code))
        return exit_code;
    struct scene scene = {.vertices = NULL};
    mlrt_tree *tree = NULL;
    mlrt_pool *pool = NULL;
    double seconds;
    int failed = load_scene(settings.scene, &scene);
    if (!failed && !settings.view) look_from_inside(&scene);
    failed = failed || (settings.view && read_view(settings.view, &scene.view)) ||
             build_tree(&scene, &(struct tree_settings){.kind = TREE_DEFAULT}, &tree, &seconds);
    if (!failed && settings.threads > 1) must_succeed(mlrt_create_pool(settings.threads, &pool));
    if (!failed) failed = draw_scene(&settings, &scene, tree, pool);
    mlrt_destroy_pool(pool);
    mlrt_destroy_tree(tree);
    free_scene(&scene);
    return end_output(failed);
}
