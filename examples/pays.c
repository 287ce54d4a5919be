/* SPDX-License-Identifier: MIT */
/*
 * pays.c - which structure pays from how many rays on: time to build and time per ray, for meshes of 1 to millions of
 * triangles
 *
 *     pays --csv                             spheres of more and more triangles, and a loop over all triangles
 *     pays --scene erw6.ply,dragon.ply       scenes
 *
 * A structure pays if building it and tracing through it takes less time than with any other. The structures are those
 * of mlrt_build_tree with each preset, and with leaves that are larger or smaller than by default; the paper's kd-tree;
 * and none: a loop over all triangles with the test of Moeller and Trumbore in float, as a programmer without a library
 * writes it (T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997). The loop is not exact.
 *
 * Rays: a picture of 256 x 256 pixels from the camera, and as many random rays, a call for each. Medians of processor
 * time of one thread. Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/steady_math.h"
#include "common/terminal.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"
#include "study/meshes.h"
#include "study/vector.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

enum { SIDE = 256, RAY_COUNT = SIDE * SIDE, MAXIMUM_RUNS = 31 };

// A loop over more triangles than this is hopeless, and would take minutes.
enum { LOOP_LIMIT = 5120, LOOP_RAYS = 1024 };

struct settings {
    struct word_list scenes;
    const char *views;
    uint32_t runs, largest; // largest: level of the largest sphere
    int csv;
};

/* ---- rays ---------------------------------------------------------------------------------------------------- */

struct rays {
    mlrt_camera camera;
    float (*picture)[2][3], (*random)[2][3]; // origin and direction
    uint32_t *triangles;
};

// Through the scene's box: from a random point in it, in any direction.
static void draw_random_rays(const struct scene *scene, struct rays *rays)
{
    uint32_t state = 1;
    float lo[3], hi[3];
    scene_bounds(scene, lo, hi);
    for (size_t i = 0; i < RAY_COUNT; i++) {
        const double z = random_between(&state, -1, 1), turns = random_between(&state, 0, 1), radius = sqrt(1 - z * z);
        const double d[3] = {radius * turn_cos(turns), radius * turn_sin(turns), z};
        for (int k = 0; k < 3; k++) {
            rays->random[i][0][k] = (float)random_between(&state, lo[k], hi[k]);
            rays->random[i][1][k] = (float)d[k];
        }
    }
}

static int make_rays(const struct scene *scene, struct rays *rays)
{
    rays->picture = must_allocate(RAY_COUNT, sizeof *rays->picture);
    rays->random = must_allocate(RAY_COUNT, sizeof *rays->random);
    rays->triangles = must_allocate(RAY_COUNT, sizeof *rays->triangles);
    draw_random_rays(scene, rays);
    if (camera_of_view(&scene->view, SIDE, SIDE, &rays->camera)) return 1;
    const mlrt_array origins = {rays->picture[0][0], sizeof *rays->picture, 0},
                     directions = {rays->picture[0][1], sizeof *rays->picture, 0};
    must_succeed(mlrt_camera_rays(&rays->camera, &origins, &directions));
    return 0;
}

static void free_rays(struct rays *rays)
{
    free(rays->picture);
    free(rays->random);
    free(rays->triangles);
}

/* ---- work ---------------------------------------------------------------------------------------------------- */

static void render_picture(const mlrt_tree *tree, const struct rays *rays)
{
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {rays->triangles, 0, 0}};
    must_succeed(mlrt_render_tiles(tree, &rays->camera, NULL, &hits, NULL, NULL));
}

static void trace_singly(const mlrt_tree *tree, const struct rays *rays)
{
    mlrt_ray ray = {.struct_size = sizeof ray};
    mlrt_hit hit = {.struct_size = sizeof hit};
    for (size_t i = 0; i < RAY_COUNT; i++) {
        memcpy(ray.origin, rays->random[i][0], sizeof ray.origin);
        memcpy(ray.direction, rays->random[i][1], sizeof ray.direction);
        must_succeed(mlrt_trace_ray(tree, &ray, NULL, &hit));
        rays->triangles[i] = hit.triangle;
    }
}

static uint32_t loop_over_triangles(const struct scene *scene, const float origin[3], const float direction[3])
{
    float nearest_t = INFINITY;
    uint32_t nearest = MLRT_NONE;
    for (uint32_t i = 0; i < scene->triangle_count; i++) {
        const uint32_t *corners = scene->indices + 3 * (size_t)i;
        const float *a = scene->vertices + 3 * (size_t)corners[0], *b = scene->vertices + 3 * (size_t)corners[1],
                    *c = scene->vertices + 3 * (size_t)corners[2];
        float e1[3], e2[3], p[3], q[3], s[3];
        subtract_float(b, a, e1), subtract_float(c, a, e2), subtract_float(origin, a, s);
        cross_float(direction, e2, p);
        const float determinant = dot_float(e1, p), reciprocal = 1 / determinant, u = dot_float(s, p) * reciprocal;
        if (determinant == 0 || !(u >= 0 && u <= 1)) continue;
        cross_float(s, e1, q);
        const float v = dot_float(direction, q) * reciprocal, t = dot_float(e2, q) * reciprocal;
        if (v >= 0 && u + v <= 1 && t > 0 && t < nearest_t) nearest_t = t, nearest = i;
    }
    return nearest;
}

// Seconds for RAY_COUNT rays, from fewer.
static double time_loop(const struct scene *scene, float (*const rays)[2][3], uint32_t *triangles)
{
    const double start = thread_seconds_now();
    for (size_t i = 0; i < LOOP_RAYS; i++) {
        const size_t ray = i * (RAY_COUNT / LOOP_RAYS);
        triangles[i] = loop_over_triangles(scene, rays[ray][0], rays[ray][1]);
    }
    return (thread_seconds_now() - start) * (RAY_COUNT / LOOP_RAYS);
}

/* ---- structures ---------------------------------------------------------------------------------------------- */

static const struct structure {
    const char *name;
    int32_t kind;            // TREE_*
    float intersection_cost; // in units of a leaf's
    int is_none;
} structures[] = {{"none", 0, 0, 1},
                  {"fast", TREE_FAST, 0, 0},
                  {"default", TREE_DEFAULT, 0, 0},
                  {"best", TREE_BEST, 0, 0},
                  {"default, small leaves", TREE_DEFAULT, 0.5f, 0},
                  {"default, large leaves", TREE_DEFAULT, 1e-4f, 0},
                  {"kdtree", TREE_KDTREE, 0, 0}};

struct figures {
    double build_seconds, picture_ns, single_ns, leaf_size;
    uint64_t memory_size;
};

static void measure_loop(const struct scene *scene, const struct rays *rays, uint32_t runs, struct figures *figures)
{
    double picture[MAXIMUM_RUNS], single[MAXIMUM_RUNS];
    for (uint32_t i = 0; i < runs; i++) {
        picture[i] = time_loop(scene, rays->picture, rays->triangles);
        single[i] = time_loop(scene, rays->random, rays->triangles);
    }
    *figures = (struct figures){.picture_ns = 1e9 / RAY_COUNT * median(picture, runs),
                                .single_ns = 1e9 / RAY_COUNT * median(single, runs)};
}

static int measure_tree(const struct scene *scene, const struct structure *structure, const struct rays *rays,
                        uint32_t runs, struct figures *figures)
{
    const struct tree_settings settings = {.kind = structure->kind, .intersection_cost = structure->intersection_cost};
    // Of a small tree many are built, so that the clock can tell.
    const uint32_t builds = scene->triangle_count < 10000 ? 20000 / (uint32_t)(scene->triangle_count + 100) : 1;
    double build[MAXIMUM_RUNS], picture[MAXIMUM_RUNS], single[MAXIMUM_RUNS];
    mlrt_tree_info info = {.struct_size = sizeof info};
    for (uint32_t i = 0; i < runs; i++) {
        mlrt_tree *tree = NULL;
        double elapsed;
        const double start = thread_seconds_now();
        for (uint32_t b = 0; b < builds; b++) {
            mlrt_destroy_tree(tree);
            tree = NULL;
            if (build_tree(scene, &settings, &tree, &elapsed)) return 1;
        }
        const double built = thread_seconds_now();
        render_picture(tree, rays);
        const double rendered = thread_seconds_now();
        trace_singly(tree, rays);
        build[i] = (built - start) / builds;
        picture[i] = rendered - built;
        single[i] = thread_seconds_now() - rendered;
        must_succeed(mlrt_get_tree_info(tree, &info));
        mlrt_destroy_tree(tree);
    }
    const double leaves = (double)(info.leaf_count - info.empty_leaf_count);
    *figures = (struct figures){median(build, runs), 1e9 / RAY_COUNT * median(picture, runs),
                                1e9 / RAY_COUNT * median(single, runs),
                                leaves > 0 ? (double)info.reference_count / leaves : 0, info.memory_size};
    return 0;
}

static int study_scene(const struct settings *settings, const char *name, const struct scene *scene)
{
    struct rays rays = {.picture = NULL};
    int failed = make_rays(scene, &rays);
    const uint32_t runs = scene->triangle_count > 200000 && settings->runs > 3 ? 3 : settings->runs;
    for (size_t i = 0; i < LENGTH(structures) && !failed; i++) {
        struct figures figures;
        const int is_hopeless = structures[i].is_none
                                    ? scene->triangle_count > LOOP_LIMIT
                                    : structures[i].kind == TREE_KDTREE && scene->triangle_count > 1500000;
        if (is_hopeless) continue;
        show_work("%s: %s ...", name, structures[i].name);
        if (structures[i].is_none)
            measure_loop(scene, &rays, runs, &figures);
        else
            failed = measure_tree(scene, &structures[i], &rays, runs, &figures);
        clear_work();
        if (failed) break;
        printf(settings->csv ? "%s,%zu,\"%s\",%.9f,%.2f,%.2f,%.2f,%" PRIu64 "\n"
                             : "%-18s %9zu %-22s %12.6f %10.2f %10.2f %6.2f %12" PRIu64 "\n",
               name, scene->triangle_count, structures[i].name, figures.build_seconds, figures.picture_ns,
               figures.single_ns, figures.leaf_size, figures.memory_size);
        fflush(stdout);
    }
    free_rays(&rays);
    return failed;
}

// A view of a mesh around 0 whose radius is 1, and a light that nothing uses.
static void look_at_mesh(struct scene *scene)
{
    scene->view = (struct view){.eye = {0.9, 0.8, 2.6}, .up = {0, 1, 0}, .vfov = 40, .light = {3, 3, 3}};
}

static int study_sheets(const struct settings *settings)
{
    static const uint32_t columns[] = {1, 2, 3, 6};
    int failed = 0;
    for (size_t i = 0; i < LENGTH(columns) && !failed; i++) {
        struct scene scene = {.vertices = NULL};
        double normal[3], axes[2][3];
        failed = make_sheet(columns[i], 1, 2.0 / columns[i], 2, &scene, normal, axes);
        look_at_mesh(&scene);
        failed = failed || study_scene(settings, "sheet", &scene);
        free_scene(&scene);
    }
    return failed;
}

static int study_spheres(const struct settings *settings)
{
    int failed = study_sheets(settings);
    for (uint32_t level = 0; level <= settings->largest && !failed; level++) {
        struct scene scene = {.vertices = NULL};
        failed = make_sphere(level, NULL, &scene);
        look_at_mesh(&scene);
        failed = failed || study_scene(settings, "sphere", &scene);
        free_scene(&scene);
    }
    return failed;
}

static int study_scenes(const struct settings *settings)
{
    int failed = 0;
    for (size_t i = 0; i < settings->scenes.count && !failed; i++) {
        struct scene scene = {.vertices = NULL};
        char name[SCENE_NAME_SIZE];
        failed = load_scene_and_view(settings->scenes.words[i], settings->views, name, &scene) ||
                 study_scene(settings, name, &scene);
        free_scene(&scene);
    }
    return failed;
}

int main(int argc, char **argv)
{
    struct settings settings = {.runs = 7, .largest = 8};
    const struct option options[] = {
        {OPTION_LIST, "--scene", &settings.scenes, "NAME|FILE,...", "scenes (default: sheets and spheres)", 0, 0},
        {OPTION_TEXT, "--views", &settings.views, "FILE.json", "views of scenes that are files", 0, 0},
        {OPTION_COUNT, "--largest", &settings.largest, "N", "spheres of up to 20 * 4^N triangles (default: 8)", 0, 9},
        {OPTION_COUNT, "--runs", &settings.runs, "N", "runs of each (default: 7; 3 of large meshes)", 1, MAXIMUM_RUNS},
        {OPTION_FLAG, "--csv", &settings.csv, NULL, "comma-separated values instead of a table", 0, 0},
    };
    int exit_code;
    if (!parse_options("pays - which structure pays from how many rays on", options, LENGTH(options), argc, argv,
                       &exit_code))
        return exit_code;
    if (settings.csv)
        puts("scene,triangles,structure,build_seconds,picture_ns,single_ns,leaf_size,memory_size");
    else
        printf("%-18s %9s %-22s %12s %10s %10s %6s %12s\n", "scene", "triangles", "structure", "build s", "picture ns",
               "single ns", "leaf", "bytes");
    return end_output(settings.scenes.count ? study_scenes(&settings) : study_spheres(&settings));
}
