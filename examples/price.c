/* SPDX-License-Identifier: MIT */
/*
 * price.c - measures the cost of exactness: the library beside a build that guesses, and its worst cases
 *
 *     price                          compares with the library of `make GUESS=1`, found in build/guess
 *     price --worst                  the worst cases
 *     price --csv                    comma-separated values, docs/data/price-*.csv
 *
 * Both libraries are loaded into this process and take turns on the same pictures, so that a machine that slows down
 * does so for both. The build that guesses takes the float filter's best guess for each decision (src/base/platform.h);
 * its culling is the same. Printed are medians, and the number of pixels that the guess gets wrong.
 *
 * In the worst cases the float filter decides as little as possible: every ray goes through a vertex, or along an axis
 * in a scene of axis-parallel walls, or everything is drawn twice. Each is measured beside the same scene with the
 * camera moved by a thousandth of the diagonal, or drawn once.
 *
 * Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#define _GNU_SOURCE
#include "common/loaded_library.h"
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAXIMUM_RUNS = 101 };

struct settings {
    struct word_list scenes;
    const char *views, *guess;
    uint32_t size, runs;
    int worst, csv;
};

static mlrt_mesh mesh_of(const struct scene *scene)
{
    return (mlrt_mesh){.struct_size = sizeof(mlrt_mesh),
                       .vertices = scene->vertices,
                       .vertex_count = scene->vertex_count,
                       .indices = scene->indices,
                       .triangle_count = scene->triangle_count};
}

/* ---- exact beside guessed ------------------------------------------------------------------------------------ */

// A call of the other library, whose own message cannot be asked for.
static void must_succeed_there(int32_t status)
{
    if (status == MLRT_OK) return;
    fprintf(stderr, "the library that guesses: %s\n", mlrt_status_string(status));
    exit(1);
}

static double render(const struct library *library, const mlrt_tree *tree, const mlrt_camera *camera,
                     uint32_t *triangles)
{
    const mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {.data = triangles}};
    const double start = thread_seconds_now();
    const int32_t status = library->render_tiles(tree, camera, NULL, &frame, NULL, NULL);
    const double seconds = thread_seconds_now() - start;
    if (library == &this_library) must_succeed(status);
    must_succeed_there(status);
    return seconds;
}

// A line is a word, then numbers: in columns, or parted by commas.
static void begin_line(int csv, const char *name)
{
    printf(csv ? "%s" : "%-18s", name);
}

static void add_number(int csv, int decimals, double value)
{
    printf(csv ? ",%.*f" : " %10.*f", decimals, value);
}

static void end_line(void)
{
    putchar('\n');
    fflush(stdout);
}

static void compare(int csv, const char *name, const struct scene *scene, const mlrt_camera *camera, uint32_t runs,
                    const struct library *guess)
{
    const mlrt_mesh mesh = mesh_of(scene);
    mlrt_tree *tree, *other_tree;
    must_succeed(mlrt_build_tree(&mesh, 1, NULL, &tree));
    must_succeed_there(guess->build_tree(&mesh, 1, NULL, &other_tree));
    const size_t pixels = (size_t)camera->width * camera->height;
    uint32_t *triangles = must_allocate(pixels, sizeof *triangles), *guessed = must_allocate(pixels, sizeof *guessed);
    double times[MAXIMUM_RUNS], other_times[MAXIMUM_RUNS], ratios[MAXIMUM_RUNS];
    for (uint32_t run = 0; run < runs; run++) {
        times[run] = render(&this_library, tree, camera, triangles);
        other_times[run] = render(guess, other_tree, camera, guessed);
        ratios[run] = times[run] / other_times[run];
    }
    size_t wrong = 0;
    for (size_t i = 0; i < pixels; i++) wrong += triangles[i] != guessed[i];
    mlrt_counters counters = {.struct_size = sizeof counters};
    const mlrt_trace_options counting = {.struct_size = sizeof counting, .counters = &counters};
    const mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {.data = triangles}};
    must_succeed(mlrt_render_tiles(tree, camera, &counting, &frame, NULL, NULL));

    const double million = (double)pixels / 1e6;
    const double lanes = (double)counters.lane_test_count, tests = (double)counters.triangle_test_count;
    const double exact = (double)(counters.exact_edge_count + counters.exact_range_count + counters.exact_order_count);
    begin_line(csv, name);
    add_number(csv, 1, million / median(times, runs));
    add_number(csv, 1, million / median(other_times, runs));
    add_number(csv, 1, 100 * (median(ratios, runs) - 1));
    add_number(csv, 1, (double)wrong / million);
    add_number(csv, 3, 100 * (double)counters.undecided_test_count / tests);
    add_number(csv, 3, 100 * (double)counters.judged_lane_count / lanes);
    add_number(csv, 3, 100 * (double)counters.tie_lane_count / lanes);
    add_number(csv, 4, 100 * exact / lanes);
    end_line();
    free(triangles);
    free(guessed);
    mlrt_destroy_tree(tree);
    guess->destroy_tree(other_tree);
}

/* ---- worst cases --------------------------------------------------------------------------------------------- */

/* Rays from one point. */
struct rays {
    float origin[3];
    float (*directions)[3];
    uint32_t side; // rows and columns
};

static double trace(const mlrt_tree *tree, const struct rays *rays, uint32_t *triangles)
{
    const size_t count = (size_t)rays->side * rays->side;
    float(*origins)[3] = must_allocate(count, sizeof *origins);
    for (size_t i = 0; i < count; i++) memcpy(origins[i], rays->origin, sizeof *origins);
    const mlrt_rays list = {.struct_size = sizeof list,
                            .row_length = rays->side,
                            .count = count,
                            .origins = {origins, 0},
                            .directions = {rays->directions, 0}};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {.data = triangles}};
    const double start = thread_seconds_now();
    must_succeed(mlrt_trace_packet(tree, &list, NULL, &hits));
    const double seconds = thread_seconds_now() - start;
    free(origins);
    return seconds;
}

static float diagonal_of(const struct scene *scene)
{
    float lo[3], hi[3], sum = 0;
    scene_bounds(scene, lo, hi);
    for (int k = 0; k < 3; k++) sum += (hi[k] - lo[k]) * (hi[k] - lo[k]);
    return sqrtf(sum);
}

/*
 * Rays towards the vertices in a picture: each pixel's ray goes to the vertex nearest to what the pixel sees, so they
 * are as coherent as a picture. With the origin at 0 the direction is the vertex itself: the ray meets it exactly.
 */
static void aim_at_vertices(const struct scene *scene, const mlrt_tree *tree, const mlrt_camera *camera,
                            struct rays *rays)
{
    const uint32_t side = rays->side;
    uint32_t *triangles = must_allocate((size_t)side * side, sizeof *triangles);
    float *u = must_allocate((size_t)side * side, sizeof *u), *v = must_allocate((size_t)side * side, sizeof *v);
    const mlrt_hits frame = {
        .struct_size = sizeof frame, .triangle = {.data = triangles}, .u = {.data = u}, .v = {.data = v}};
    must_succeed(mlrt_render_tiles(tree, camera, NULL, &frame, NULL, NULL));
    must_succeed(mlrt_camera_rays(camera, NULL, &(mlrt_array){.data = rays->directions}));
    for (size_t i = 0; i < (size_t)side * side; i++) {
        if (triangles[i] == MLRT_NONE) continue;
        const float w = 1 - u[i] - v[i];
        const uint32_t corner = u[i] > w && u[i] > v[i] ? 1 : v[i] > w ? 2 : 0;
        const float *vertex = scene->vertices + 3 * (size_t)scene->indices[3 * (size_t)triangles[i] + corner];
        for (int k = 0; k < 3; k++) rays->directions[i][k] = vertex[k] - rays->origin[k];
    }
    free(triangles);
    free(u);
    free(v);
}

/* Puts the camera into a plane of the nearest vertex across each axis, looking along an axis with dyadic steps. */
static void align(const struct scene *scene, mlrt_camera *camera)
{
    for (int k = 0; k < 3; k++) {
        float nearest = INFINITY;
        for (size_t i = 0; i < scene->vertex_count; i++) {
            const float c = scene->vertices[3 * i + (size_t)k];
            if (fabsf(c - camera->eye[k]) < fabsf(nearest - camera->eye[k])) nearest = c;
        }
        if (isfinite(nearest)) camera->eye[k] = nearest;
    }
    int main_axis = 0;
    float forward[3];
    for (int k = 0; k < 3; k++) {
        forward[k] = camera->d00[k] + 0.5f * (float)camera->width * (camera->dx[k] + camera->dy[k]);
        if (fabsf(forward[k]) > fabsf(forward[main_axis])) main_axis = k;
    }
    const int across = (main_axis + 1) % 3, up = (main_axis + 2) % 3;
    for (int k = 0; k < 3; k++) camera->d00[k] = camera->dx[k] = camera->dy[k] = 0;
    camera->d00[main_axis] = forward[main_axis] < 0 ? -1.0f : 1.0f;
    camera->d00[across] = camera->d00[up] = -0.5f;
    camera->dx[across] = camera->dy[up] = 1.0f / (float)camera->width;
    camera->sample_x = camera->sample_y = 0;
}

static void print_worst(int csv, const char *scene, const char *what, double *times, double *other_times, uint32_t runs,
                        double rays)
{
    const double worst = median(times, runs) * 1e9 / rays, plain = median(other_times, runs) * 1e9 / rays;
    begin_line(csv, scene);
    printf(csv ? ",\"%s\"" : " %-34s", what);
    add_number(csv, 1, worst);
    add_number(csv, 1, plain);
    add_number(csv, 2, worst / plain);
    end_line();
}

static void measure_vertices(int csv, const char *name, const struct scene *scene, const mlrt_tree *tree,
                             const mlrt_camera *camera, int from_zero, uint32_t runs)
{
    mlrt_camera moved = *camera;
    if (from_zero) moved.eye[0] = moved.eye[1] = moved.eye[2] = 0;
    struct rays rays = {.side = camera->width};
    memcpy(rays.origin, moved.eye, sizeof rays.origin);
    rays.directions = must_allocate((size_t)rays.side * rays.side, sizeof *rays.directions);
    uint32_t *triangles = must_allocate((size_t)rays.side * rays.side, sizeof *triangles);
    aim_at_vertices(scene, tree, &moved, &rays);
    struct rays other = rays;
    other.origin[0] += 0.001f * diagonal_of(scene);
    double times[MAXIMUM_RUNS], other_times[MAXIMUM_RUNS];
    for (uint32_t run = 0; run < runs; run++) {
        times[run] = trace(tree, &rays, triangles);
        other_times[run] = trace(tree, &other, triangles);
    }
    print_worst(csv, name, from_zero ? "vertices, exactly (from 0,0,0)" : "vertices, from the eye", times, other_times,
                runs, (double)rays.side * rays.side);
    free(rays.directions);
    free(triangles);
}

static void measure_alignment(int csv, const char *name, const struct scene *scene, const mlrt_tree *tree,
                              const mlrt_camera *camera, uint32_t runs)
{
    mlrt_camera aligned = *camera;
    align(scene, &aligned);
    mlrt_camera moved = aligned;
    for (int k = 0; k < 3; k++) moved.eye[k] += 0.000577f * diagonal_of(scene);
    uint32_t *triangles = must_allocate((size_t)camera->width * camera->height, sizeof *triangles);
    double times[MAXIMUM_RUNS], other_times[MAXIMUM_RUNS];
    for (uint32_t run = 0; run < runs; run++) {
        times[run] = render(&this_library, tree, &aligned, triangles);
        other_times[run] = render(&this_library, tree, &moved, triangles);
    }
    print_worst(csv, name, "axis-parallel, eye in planes", times, other_times, runs,
                (double)camera->width * camera->height);
    free(triangles);
}

static void measure_doubling(int csv, const char *name, const struct scene *scene, const mlrt_tree *tree,
                             const mlrt_camera *camera, uint32_t runs)
{
    const mlrt_mesh meshes[2] = {mesh_of(scene), mesh_of(scene)};
    mlrt_tree *doubled;
    must_succeed(mlrt_build_tree(meshes, 2, NULL, &doubled));
    uint32_t *triangles = must_allocate((size_t)camera->width * camera->height, sizeof *triangles);
    double times[MAXIMUM_RUNS], other_times[MAXIMUM_RUNS];
    for (uint32_t run = 0; run < runs; run++) {
        times[run] = render(&this_library, doubled, camera, triangles);
        other_times[run] = render(&this_library, tree, camera, triangles);
    }
    print_worst(csv, name, "everything drawn twice", times, other_times, runs, (double)camera->width * camera->height);
    free(triangles);
    mlrt_destroy_tree(doubled);
}

static void measure_worst_cases(int csv, const char *name, const struct scene *scene, const mlrt_camera *camera,
                                uint32_t runs)
{
    const mlrt_mesh mesh = mesh_of(scene);
    mlrt_tree *tree;
    must_succeed(mlrt_build_tree(&mesh, 1, NULL, &tree));
    measure_vertices(csv, name, scene, tree, camera, 0, runs);
    measure_vertices(csv, name, scene, tree, camera, 1, runs);
    measure_alignment(csv, name, scene, tree, camera, runs);
    measure_doubling(csv, name, scene, tree, camera, runs);
    mlrt_destroy_tree(tree);
}

/* ---- command line -------------------------------------------------------------------------------------------- */

static int run(const struct settings *settings)
{
    struct library guess = {.handle = NULL};
    if (!settings->worst && load_library(settings->guess, &guess)) {
        fprintf(stderr, "It is built by: make GUESS=1 library\n");
        return 1;
    }
    if (!settings->worst && !guess.build_tree) {
        fprintf(stderr, "%s: a library from before mlrt_build_tree\n", settings->guess);
        close_library(&guess);
        return 1;
    }
    const int csv = settings->csv;
    if (settings->worst) {
        puts(csv ? "scene,case,ns,plain_ns,ratio"
                 : "scene              worst case                             ns/ray      plain      ratio");
    } else {
        puts(csv ? "scene,exact_mrays,guess_mrays,price_percent,wrong_per_million,undecided_percent,double_percent,"
                   "ties_percent,exact_percent"
                 : "scene                   exact      guess    price %    wrong/M undecided%   double %     ties %    "
                   "exact %");
    }
    for (size_t i = 0; i < settings->scenes.count; i++) {
        struct scene scene = {.vertices = NULL};
        mlrt_camera camera;
        char name[SCENE_NAME_SIZE];
        if (load_scene_and_view(settings->scenes.words[i], settings->views, name, &scene) ||
            camera_of_view(&scene.view, settings->size, settings->size, &camera)) {
            free_scene(&scene);
            return 1;
        }
        if (settings->worst) {
            measure_worst_cases(csv, name, &scene, &camera, settings->runs);
        } else {
            compare(csv, name, &scene, &camera, settings->runs, &guess);
        }
        free_scene(&scene);
    }
    return 0;
}

int main(int argc, char **argv)
{
    struct settings settings = {.guess = "build/guess/libmlrt.so", .size = 1024, .runs = 15};
    const struct option options[] = {
        {OPTION_LIST, "--scene", &settings.scenes, "NAME|FILE,...", "scenes (default: room,office,building,scan)", 0,
         0},
        {OPTION_TEXT, "--views", &settings.views, "FILE.json", "views of scenes that are files", 0, 0},
        {OPTION_TEXT, "--guess", &settings.guess, "FILE.so",
         "the library made with GUESS=1 (default: build/guess/libmlrt.so)", 0, 0},
        {OPTION_COUNT, "--size", &settings.size, "N", "pixels per side (default: 1024)", 4, 8192},
        {OPTION_COUNT, "--runs", &settings.runs, "N", "runs of each (default: 15)", 1, MAXIMUM_RUNS},
        {OPTION_FLAG, "--worst", &settings.worst, "", "the worst cases, and not the price", 0, 0},
        {OPTION_FLAG, "--csv", &settings.csv, "", "comma-separated values instead of columns", 0, 0},
    };
    int exit_code;
    if (!parse_options("price - what exactness costs", options, sizeof options / sizeof *options, argc, argv,
                       &exit_code))
        return exit_code;
    if (settings.scenes.count == 0) settings.scenes = (struct word_list){4, {"room", "office", "building", "scan"}};
    return end_output(run(&settings));
}
