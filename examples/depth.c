/* SPDX-License-Identifier: MIT */
/*
 * depth.c - measures how deep a kd-tree must be, and how many triangles are so few that a single leaf is as fast
 *
 *     depth                               small meshes: the tuned kd-tree against a single leaf with all triangles
 *     depth --scene erw6.ply,building     scenes: kd-trees of limited depth against the tuned kd-tree
 *
 * Two trees over the same triangles take turns at the same rays, so that a machine that slows down does so for both.
 * Printed are medians of times, and medians of the ratios of successive runs.
 *
 * Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/shapes.h"
#include "common/steady_math.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"
#include "study/meshes.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

enum { MAXIMUM_RUNS = 101 };

struct settings {
    struct word_list scenes;
    const char *views;
    uint32_t size, rays, runs, limit; // size 0: the study's default; limit 0: all of them
    int csv;
};

/* ---- work ---------------------------------------------------------------------------------------------------- */

/* The same picture from the camera and as an array of rays; and rays that have nothing to do with each other. */
struct rays {
    mlrt_camera camera;
    size_t pixel_count, random_count;
    float (*origins)[3], (*directions)[3];
    float (*random_origins)[3], (*random_directions)[3];
    float *t;
    uint32_t *triangles;
};

/* Origins anywhere in the scene's box, directions all as likely. */
static void draw_random_rays(const struct scene *scene, struct rays *rays)
{
    uint32_t state = 1;
    float lo[3], hi[3];
    scene_bounds(scene, lo, hi);
    for (size_t i = 0; i < rays->random_count; i++) {
        double d[3], length;
        do {
            for (int k = 0; k < 3; k++) d[k] = random_between(&state, -1, 1);
            length = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        } while (length > 1 || length < 0.01);
        for (int k = 0; k < 3; k++) {
            rays->random_origins[i][k] = (float)random_between(&state, lo[k], hi[k]);
            rays->random_directions[i][k] = (float)d[k];
        }
    }
}

static int make_rays(const struct scene *scene, const struct settings *settings, uint32_t size, struct rays *rays)
{
    rays->pixel_count = (size_t)size * size;
    rays->random_count = settings->rays;
    const size_t largest = rays->pixel_count > rays->random_count ? rays->pixel_count : rays->random_count;
    rays->origins = must_allocate(rays->pixel_count, sizeof *rays->origins);
    rays->directions = must_allocate(rays->pixel_count, sizeof *rays->directions);
    rays->random_origins = must_allocate(rays->random_count, sizeof *rays->random_origins);
    rays->random_directions = must_allocate(rays->random_count, sizeof *rays->random_directions);
    rays->t = must_allocate(largest, sizeof *rays->t);
    rays->triangles = must_allocate(largest, sizeof *rays->triangles);
    draw_random_rays(scene, rays);
    if (camera_of_view(&scene->view, size, size, &rays->camera)) return 1;
    must_succeed(
        mlrt_camera_rays(&rays->camera, &(mlrt_array){.data = rays->origins}, &(mlrt_array){.data = rays->directions}));
    return 0;
}

static void free_rays(struct rays *rays)
{
    free(rays->origins);
    free(rays->directions);
    free(rays->random_origins);
    free(rays->random_directions);
    free(rays->t);
    free(rays->triangles);
}

static mlrt_hits hits_of(const struct rays *rays)
{
    return (mlrt_hits){.struct_size = sizeof(mlrt_hits), .t = {.data = rays->t}, .triangle = {.data = rays->triangles}};
}

static void render_picture(const mlrt_tree *tree, const struct rays *rays)
{
    const mlrt_hits frame = hits_of(rays);
    must_succeed(mlrt_render_tiles(tree, &rays->camera, NULL, &frame, NULL, NULL));
}

static void trace_array(const mlrt_tree *tree, const struct rays *rays)
{
    const mlrt_hits hits = hits_of(rays);
    const mlrt_rays list = {.struct_size = sizeof list,
                            .row_length = rays->camera.width,
                            .count = rays->pixel_count,
                            .origins = {rays->origins, 0},
                            .directions = {rays->directions, 0}};
    must_succeed(mlrt_trace_packet(tree, &list, NULL, &hits));
}

static void trace_random_array(const mlrt_tree *tree, const struct rays *rays)
{
    const mlrt_hits hits = hits_of(rays);
    const mlrt_rays list = {.struct_size = sizeof list,
                            .count = rays->random_count,
                            .origins = {rays->random_origins, 0},
                            .directions = {rays->random_directions, 0}};
    must_succeed(mlrt_trace_packet(tree, &list, NULL, &hits));
}

static void trace_single_rays(const mlrt_tree *tree, const struct rays *rays)
{
    for (size_t i = 0; i < rays->random_count; i++) {
        mlrt_ray ray = {.struct_size = sizeof ray};
        mlrt_hit hit = {.struct_size = sizeof hit};
        memcpy(ray.origin, rays->random_origins[i], sizeof ray.origin);
        memcpy(ray.direction, rays->random_directions[i], sizeof ray.direction);
        must_succeed(mlrt_trace_ray(tree, &ray, NULL, &hit));
        rays->t[i] = hit.t;
        rays->triangles[i] = hit.triangle;
    }
}

struct work {
    const char *name;
    void (*run)(const mlrt_tree *tree, const struct rays *rays);
    int is_picture; // 1 = of the pixels, 0 = of the random rays
};

enum { WORK_PICTURE, WORK_ARRAY, WORK_RANDOM_ARRAY, WORK_SINGLE, WORK_COUNT };

static const struct work works[WORK_COUNT] = {
    [WORK_PICTURE] = {"picture", render_picture, 1},
    [WORK_ARRAY] = {"array", trace_array, 1},
    [WORK_RANDOM_ARRAY] = {"random_array", trace_random_array, 0},
    [WORK_SINGLE] = {"single", trace_single_rays, 0},
};

struct comparison {
    double ns, other_ns; // per ray
    double ratio;        // other / first
};

/* The processor's time: nothing here has threads, and what it does for others in between is not counted. */
static double seconds_of(const struct work *work, const mlrt_tree *tree, const struct rays *rays)
{
    const clock_t start = clock();
    work->run(tree, rays);
    return (double)(clock() - start) / CLOCKS_PER_SEC;
}

/* Who comes second finds the rays in the cache, so each is first in half of the pairs. */
static struct comparison compare(const struct work *work, const mlrt_tree *tree, const mlrt_tree *other,
                                 const struct rays *rays, uint32_t runs)
{
    double times[MAXIMUM_RUNS], other_times[MAXIMUM_RUNS], ratios[MAXIMUM_RUNS];
    for (uint32_t run = 0; run < runs; run++) {
        if (run % 2 == 0) times[run] = seconds_of(work, tree, rays);
        other_times[run] = seconds_of(work, other, rays);
        if (run % 2 != 0) times[run] = seconds_of(work, tree, rays);
        ratios[run] = other_times[run] / times[run];
    }
    const double per_ray = 1e9 / (double)(work->is_picture ? rays->pixel_count : rays->random_count);
    return (struct comparison){median(times, runs) * per_ray, median(other_times, runs) * per_ray,
                               median(ratios, runs)};
}

static mlrt_tree_info info_of(const mlrt_tree *tree)
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    must_succeed(mlrt_get_tree_info(tree, &info));
    return info;
}

/* ---- small meshes -------------------------------------------------------------------------------------------- */

static struct view view_from(double x, double y, double z)
{
    return (struct view){.eye = {x, y, z}, .up = {0, 1, 0}, .vfov = 45};
}

static void add_triangle(struct scene *scene, uint32_t *state, double size)
{
    double centre[3];
    for (int k = 0; k < 3; k++) centre[k] = random_between(state, -1, 1);
    for (int i = 0; i < 3; i++) {
        scene->indices[scene->vertex_count] = (uint32_t)scene->vertex_count;
        float *vertex = scene->vertices + 3 * scene->vertex_count++;
        for (int k = 0; k < 3; k++) vertex[k] = (float)(centre[k] + random_between(state, -size, size));
    }
    scene->triangle_count++;
}

/* Triangles anywhere, smaller where they are many: gaps are left at any number. */
static int make_soup(uint32_t count, struct scene *scene)
{
    uint32_t state = count;
    scene->vertices = must_allocate(9 * (size_t)count, sizeof *scene->vertices);
    scene->indices = must_allocate(3 * (size_t)count, sizeof *scene->indices);
    for (uint32_t i = 0; i < count; i++) add_triangle(scene, &state, 1 / cbrt(count));
    scene->view = view_from(0.4, 0.9, 3);
    return 0;
}

static void add_wall(struct shapes *shapes, uint32_t number)
{
    static const double walls[6][4][3] = {
        {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}},   {{-5, 0, -5}, {5, 0, -5}, {5, 4, -5}, {-5, 4, -5}},
        {{-5, 0, -5}, {-5, 0, 5}, {-5, 4, 5}, {-5, 4, -5}}, {{5, 0, -5}, {5, 0, 5}, {5, 4, 5}, {5, 4, -5}},
        {{-5, 4, -5}, {5, 4, -5}, {5, 4, 5}, {-5, 4, 5}},   {{-5, 0, 5}, {5, 0, 5}, {5, 4, 5}, {-5, 4, 5}}};
    const struct place place = world_place();
    add_quad(shapes, &place, walls[number]);
}

/* One of 5 x 5 boxes that stand on the floor. */
static void add_furniture(struct shapes *shapes, uint32_t number)
{
    const struct place place = world_place();
    const double x = 1.8 * (double)(number * 7 % 25 / 5) - 4.1, z = 1.8 * (double)(number * 7 % 5) - 4.1;
    add_box(shapes, &place, x, 0, z, x + 0.6, 0.5 + 0.1 * (double)(number % 7), z + 0.8);
}

static void add_poster(struct shapes *shapes, uint32_t number)
{
    const struct place place = world_place();
    const double x = 1.5 * (double)number - 4;
    const double corners[4][3] = {{x, 2, -4.9}, {x + 1, 2, -4.9}, {x + 1, 3, -4.9}, {x, 3, -4.9}};
    add_quad(shapes, &place, corners);
}

/* Walls, then boxes in the room, and posters on a wall for the rest. Everything is parallel to an axis. */
static int make_box_room(uint32_t count, struct scene *scene)
{
    struct shapes shapes = {.scene = scene};
    const uint32_t wall_count = count < 12 ? count / 2 : 6, rest = count - 2 * wall_count;
    for (uint32_t i = 0; i < wall_count; i++) add_wall(&shapes, i);
    for (uint32_t i = 0; i < rest / 12; i++) add_furniture(&shapes, i);
    for (uint32_t i = 0; i < rest % 12 / 2; i++) add_poster(&shapes, i);
    scene->view = view_from(3.5, 2.5, 4.5);
    scene->view.look[1] = 1.5;
    scene->view.vfov = 60;
    return shapes.failed;
}

/* A grid of as many triangles, as square as powers of two and three allow. */
static int make_grid(uint32_t count, struct scene *scene)
{
    double normal[3], axes[2][3];
    uint32_t rows = 1;
    for (uint32_t i = 2; i * i <= count / 2; i++)
        if (count / 2 % i == 0) rows = i;
    const uint32_t columns = count / 2 / rows;
    if (make_sheet(columns, rows, 2.0 / columns, 2.0 / rows, scene, normal, axes)) return 1;
    scene->view = view_from(1.9, 0.6, 2.2);
    return 0;
}

static int make_ball(uint32_t count, struct scene *scene)
{
    uint32_t level = 0;
    while (20u << 2 * level < count) level++;
    return make_sphere(level, NULL, scene);
}

static const struct {
    const char *name;
    int (*make)(uint32_t count, struct scene *scene);
    uint32_t counts[13]; // up to the first 0
} makers[] = {
    {"soup", make_soup, {1, 2, 4, 8, 12, 16, 24, 32, 48, 64, 128, 256}},
    {"box room", make_box_room, {2, 4, 8, 12, 16, 24, 32, 48, 64, 128, 256}},
    {"grid", make_grid, {2, 4, 8, 12, 16, 24, 32, 48, 64, 128, 256}},
    {"sphere", make_ball, {20, 80, 320}},
};

static void print_small_head(const struct settings *settings)
{
    if (settings->csv) {
        puts("mesh,triangles,depth,leaves,work,tree_ns,leaf_ns,ratio");
        return;
    }
    puts("Time per ray in ns with the tuned tree, with a single leaf of everything, and leaf / tree: below 1 the leaf "
         "is faster.\n");
    printf("%-9s %5s %6s %6s", "mesh", "tri", "depth", "leaves");
    for (size_t i = 0; i < WORK_COUNT; i++) printf(" | %-12s  leaf  ratio", works[i].name);
    puts("");
}

static void print_small_row(const struct settings *settings, const char *name, const mlrt_tree_info *info,
                            const struct comparison comparisons[WORK_COUNT])
{
    if (!settings->csv)
        printf("%-9s %5" PRIu64 " %6" PRIu32 " %6" PRIu64, name, info->triangle_count, info->depth, info->leaf_count);
    for (size_t i = 0; i < WORK_COUNT; i++) {
        const struct comparison *c = &comparisons[i];
        if (settings->csv)
            printf("%s,%" PRIu64 ",%" PRIu32 ",%" PRIu64 ",%s,%.3f,%.3f,%.4f\n", name, info->triangle_count,
                   info->depth, info->leaf_count, works[i].name, c->ns, c->other_ns, c->ratio);
        else
            printf(" | %8.1f %8.1f %6.2f", c->ns, c->other_ns, c->ratio);
    }
    if (!settings->csv) puts("");
    fflush(stdout);
}

static int study_small(const struct settings *settings, const char *name, struct scene *scene)
{
    const struct tree_settings usual = {.kind = TREE_KDTREE_TUNED};
    // A step that costs a million tests never pays: retraction makes everything one leaf.
    const struct tree_settings one_leaf = {.kind = TREE_KDTREE_TUNED, .traversal_cost = 1e6f};
    mlrt_tree *tree = NULL, *leaf = NULL;
    struct rays rays = {.t = NULL};
    double seconds;
    int failed = build_tree(scene, &usual, &tree, &seconds) || build_tree(scene, &one_leaf, &leaf, &seconds) ||
                 make_rays(scene, settings, settings->size ? settings->size : 256, &rays);
    if (!failed && info_of(leaf).leaf_count != 1) {
        fprintf(stderr, "%s: the tree that should be a single leaf is not\n", name);
        failed = 1;
    }
    if (!failed) {
        struct comparison comparisons[WORK_COUNT];
        for (size_t i = 0; i < WORK_COUNT; i++) comparisons[i] = compare(&works[i], tree, leaf, &rays, settings->runs);
        const mlrt_tree_info info = info_of(tree);
        print_small_row(settings, name, &info, comparisons);
    }
    free_rays(&rays);
    mlrt_destroy_tree(tree);
    mlrt_destroy_tree(leaf);
    return failed;
}

static int study_small_meshes(const struct settings *settings)
{
    int failed = 0;
    print_small_head(settings);
    for (size_t i = 0; i < LENGTH(makers); i++) {
        for (const uint32_t *count = makers[i].counts; *count && !failed; count++) {
            struct scene scene = {.vertices = NULL};
            failed = makers[i].make(*count, &scene) || study_small(settings, makers[i].name, &scene);
            free_scene(&scene);
        }
    }
    return failed;
}

/* ---- depth --------------------------------------------------------------------------------------------------- */

static const uint32_t depth_limits[] = {60, 52, 48, 44, 40, 36, 32, 28, 24, 20, 16, 12, 8};

/* Where a picture takes this many times as long as with the tuned tree, the limits below are not tried. */
#define HOPELESS 3.0

static void print_depth_head(const struct settings *settings)
{
    if (settings->csv) {
        puts("scene,limit,depth,sah_cost,picture_ns,picture_ratio,single_ns,single_ratio,build_seconds,memory_size");
        return;
    }
    puts("Trees of at most `limit` inner nodes above a leaf, 0 = the default. ns: per ray, of the picture and of "
         "single\n"
         "random rays; ratio: to the tuned tree, whose runs took turns with these.\n");
    printf("%-18s %5s %5s %9s %9s %7s %9s %7s %8s %9s\n", "scene", "limit", "depth", "sah_cost", "picture", "ratio",
           "single", "ratio", "build s", "MiB");
}

static void print_depth_row(const struct settings *settings, const char *name, uint32_t limit,
                            const mlrt_tree_info *info, const struct comparison *picture,
                            const struct comparison *single)
{
    const char *format = settings->csv ? "%s,%" PRIu32 ",%" PRIu32 ",%.3f,%.3f,%.4f,%.3f,%.4f,%.3f,%.0f\n"
                                       : "%-18s %5" PRIu32 " %5" PRIu32 " %9.2f %9.1f %7.3f %9.1f %7.3f %8.2f %9.1f\n";
    const double memory = (double)info->memory_size / (settings->csv ? 1 : 1048576);
    printf(format, name, limit, info->depth, info->sah_cost, picture->other_ns, picture->ratio, single->other_ns,
           single->ratio, info->build_seconds, memory);
    fflush(stdout);
}

/* A row of the table. Returns how much longer the picture takes than with the tuned tree. */
static double compare_trees(const struct settings *settings, const char *name, uint32_t limit, const mlrt_tree *tree,
                            const mlrt_tree *other, const struct rays *rays)
{
    const mlrt_tree_info info = info_of(other);
    const struct comparison picture = compare(&works[WORK_PICTURE], tree, other, rays, settings->runs);
    const struct comparison single = compare(&works[WORK_SINGLE], tree, other, rays, settings->runs);
    print_depth_row(settings, name, limit, &info, &picture, &single);
    return picture.ratio;
}

static int study_depth(const struct settings *settings, const char *name, const struct scene *scene)
{
    struct tree_settings build = {.kind = TREE_KDTREE_TUNED};
    mlrt_tree *tree = NULL;
    struct rays rays = {.t = NULL};
    double seconds, ratio = 1;
    int failed = build_tree(scene, &build, &tree, &seconds) ||
                 make_rays(scene, settings, settings->size ? settings->size : 1024, &rays);
    if (!failed) compare_trees(settings, name, 0, tree, tree, &rays);
    const uint32_t *limits = settings->limit ? &settings->limit : depth_limits;
    const size_t limit_count = settings->limit ? 1 : LENGTH(depth_limits);
    for (size_t i = 0; i < limit_count && ratio < HOPELESS && !failed; i++) {
        mlrt_tree *other = NULL;
        build.max_depth = limits[i];
        failed = build_tree(scene, &build, &other, &seconds);
        if (!failed) ratio = compare_trees(settings, name, limits[i], tree, other, &rays);
        mlrt_destroy_tree(other);
    }
    free_rays(&rays);
    mlrt_destroy_tree(tree);
    return failed;
}

static int study_depths(const struct settings *settings)
{
    int failed = 0;
    print_depth_head(settings);
    for (size_t i = 0; i < settings->scenes.count && !failed; i++) {
        struct scene scene = {.vertices = NULL};
        char name[SCENE_NAME_SIZE];
        failed = load_scene_and_view(settings->scenes.words[i], settings->views, name, &scene) ||
                 study_depth(settings, name, &scene);
        free_scene(&scene);
    }
    return failed;
}

int main(int argc, char **argv)
{
    struct settings settings = {.rays = 16384, .runs = 9};
    const struct option options[] = {
        {OPTION_LIST, "--scene", &settings.scenes, "NAME|FILE,...",
         "trees of limited depth on these scenes (default: small meshes against a single leaf)", 0, 0},
        {OPTION_TEXT, "--views", &settings.views, "FILE.json", "views of scenes that are files", 0, 0},
        {OPTION_COUNT, "--size", &settings.size, "N", "pixels per side (default: 256, with --scene 1024)", 4, 8192},
        {OPTION_COUNT, "--rays", &settings.rays, "N", "random rays (default: 16384)", 1, 1u << 24},
        {OPTION_COUNT, "--runs", &settings.runs, "N", "runs of each (default: 9)", 1, MAXIMUM_RUNS},
        {OPTION_COUNT, "--limit", &settings.limit, "N",
         "with --scene: this limit only (default: 60, 52, 48, 44, ... as far down as it makes sense)", 1, 60},
        {OPTION_FLAG, "--csv", &settings.csv, "", "comma-separated values instead of tables", 0, 0},
    };
    int exit_code;
    if (!parse_options("depth - how much kd-tree a scene needs", options, LENGTH(options), argc, argv, &exit_code))
        return exit_code;
    return end_output(settings.scenes.count ? study_depths(&settings) : study_small_meshes(&settings));
}
